"""The stress suite: what a table can do to an engine, and what the engine survives of it."""

from ghostball.validation.stress.families import FAMILIES
from ghostball.validation.stress.findings import Finding, StressFolder
from ghostball.validation.stress.run import DEFAULT_ENGINES, StressOutcome, run_stress
from ghostball.validation.stress.trial import Suite

__all__ = [
    "DEFAULT_ENGINES",
    "FAMILIES",
    "Finding",
    "StressFolder",
    "StressOutcome",
    "Suite",
    "run_stress",
]
