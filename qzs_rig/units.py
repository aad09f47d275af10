"""The four degrees of freedom, by the names and in the order used everywhere; units; gravity."""

from __future__ import annotations

DOFS = ('vertical', 'horizontal', 'vertical_rotation', 'horizontal_rotation')
"""Order of every last axis of length four. Frames are z up (REP 103): vertical is +z,
horizontal is +x, vertical_rotation turns about +z (yaw), horizontal_rotation about +y (pitch)."""

TRANSLATIONS = DOFS[:2]
ROTATIONS = DOFS[2:]

QUANTITIES = ('displacement', 'velocity', 'acceleration')
"""What a base may hold constant over frequency; the index is the order of the time derivative, so
the amplitude of the displacement falls as frequency to the power of -index."""


def displacement_unit(dof: str) -> str:
    """`m` for a translation, `rad` for a rotation."""
    return 'm' if dof in TRANSLATIONS else 'rad'


GRAVITY = 9.80665
"""Standard gravity in m/s² (CGPM 1901)."""
