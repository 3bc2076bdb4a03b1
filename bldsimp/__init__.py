"""bldsimp makes 3D building models light: fewest points, no crack, a certified error."""

__version__ = "0.1.0"
