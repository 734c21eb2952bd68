"""Ensembles: distributions compared where single trajectories can't be.

A shot past its predictability horizon ends elsewhere in every engine, and with every rounding. What
can still be compared is how a shot ends that is perturbed again and again: the distributions of
rest positions, collision counts and energy.
"""

from ghostball.validation.ensembles.compare import (
    ENERGY_PARTS,
    QUANTITIES,
    Compared,
    Comparison,
    compare,
)
from ghostball.validation.ensembles.ensemble_record import (
    REFERENCE,
    EnsembleRecord,
    Members,
)
from ghostball.validation.ensembles.ensembles_folder import Ensembles
from ghostball.validation.ensembles.member import MemberResult
from ghostball.validation.ensembles.members import EnsembleError, Size, perturb
from ghostball.validation.ensembles.run import check_ensembles, run_ensembles

__all__ = [
    "ENERGY_PARTS",
    "QUANTITIES",
    "REFERENCE",
    "Compared",
    "Comparison",
    "EnsembleError",
    "EnsembleRecord",
    "Ensembles",
    "MemberResult",
    "Members",
    "Size",
    "check_ensembles",
    "compare",
    "perturb",
    "run_ensembles",
]
