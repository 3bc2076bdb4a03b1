"""Textured models as a viewer shows them: read without bldsimp's own readers, drawn without a screen."""
