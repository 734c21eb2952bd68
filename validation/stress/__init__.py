"""The stress suite: what a table can do to an engine, and what the engine survives of it."""

from ghostball.validation.stress.families import FAMILIES, Family
from ghostball.validation.stress.findings import Finding, StressFolder
from ghostball.validation.stress.run import DEFAULT_ENGINES, StressOutcome, run_stress
from ghostball.validation.stress.trial import SceneTrial, StressError, Suite, Trial, Verdict

__all__ = [
    "DEFAULT_ENGINES",
    "FAMILIES",
    "Family",
    "Finding",
    "SceneTrial",
    "StressError",
    "StressFolder",
    "StressOutcome",
    "Suite",
    "Trial",
    "Verdict",
    "run_stress",
]
