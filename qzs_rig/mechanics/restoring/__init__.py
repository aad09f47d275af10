"""Restoring laws (MODEL section 3). A new law is one file and one line in RESTORING."""

from __future__ import annotations

from qzs_rig.mechanics.restoring.closed_form import CLOSED_FORM
from qzs_rig.mechanics.restoring.corrected import CORRECTED
from qzs_rig.mechanics.restoring.geometric import GEOMETRIC
from qzs_rig.mechanics.restoring.law import RestoringLaw
from qzs_rig.mechanics.restoring.linear import LINEAR
from qzs_rig.mechanics.restoring.printed import PRINTED
from qzs_rig.mechanics.restoring.symmetric import SYMMETRIC
from qzs_rig.mechanics.restoring.taylor import TAYLOR

RESTORING: dict[str, RestoringLaw] = {
    law.name: law for law in (CORRECTED, CLOSED_FORM, TAYLOR, PRINTED, SYMMETRIC, LINEAR, GEOMETRIC)
}
