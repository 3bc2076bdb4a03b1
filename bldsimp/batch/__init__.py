"""Simplify many files, each alone: find them, plan, share them among processes, and record each in a manifest."""
