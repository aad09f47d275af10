"""A virtual test rig for a quasi-zero-stiffness vibration isolation platform."""

__version__ = '0.2.0'
