"""The stress families: generated shots that test the limits of engines, judged like scenes."""

from ghostball.validation.stress.families import FAMILIES, chosen_shots, path_of
from ghostball.validation.stress.run import DEFAULT_ENGINES, run_stress
from ghostball.validation.stress.shots import StressError, StressFamily, StressShot, StressSize

__all__ = [
    "DEFAULT_ENGINES",
    "FAMILIES",
    "StressError",
    "StressFamily",
    "StressShot",
    "StressSize",
    "chosen_shots",
    "path_of",
    "run_stress",
]
