"""Restoring laws (MODEL section 3). A new law is one file and one line in RESTORING."""

from __future__ import annotations

from qzs_rig.mechanics.restoring.closed_form import CLOSED_FORM, CORRECTED
from qzs_rig.mechanics.restoring.geometric import GEOMETRIC
from qzs_rig.mechanics.restoring.law import RestoringLaw
from qzs_rig.mechanics.restoring.polynomials import LINEAR, PRINTED, SYMMETRIC, TAYLOR

RESTORING: dict[str, RestoringLaw] = {
    law.name: law for law in (CORRECTED, CLOSED_FORM, TAYLOR, PRINTED, SYMMETRIC, LINEAR, GEOMETRIC)
}
