"""The stages of the pipeline, arrays to arrays: they know neither files nor the screen."""
