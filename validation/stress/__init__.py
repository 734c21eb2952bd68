"""The stress families: generated shots that try to break an engine, judged like any other."""

from ghostball.validation.stress.families import FAMILIES, chosen_shots, path_of
from ghostball.validation.stress.run import DEFAULT_ENGINES, run_stress
from ghostball.validation.stress.shots import Family, Shot, Size, StressError

__all__ = [
    "DEFAULT_ENGINES",
    "FAMILIES",
    "Family",
    "Shot",
    "Size",
    "StressError",
    "chosen_shots",
    "path_of",
    "run_stress",
]
