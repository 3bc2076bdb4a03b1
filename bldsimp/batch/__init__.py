"""Many files, each alone: found, planned, shared out to processes, and recorded in a manifest."""
