"""Standard gravity."""

GRAVITY = 9.80665
"""In m/s² (CGPM 1901)."""
