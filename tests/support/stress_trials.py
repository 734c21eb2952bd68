"""Trials of the families of the stress suite, by name.

They are made when a test asks for them: a module that did so while it is imported would cost every
process of every test run what they take.
"""

from __future__ import annotations

from functools import cache

from ghostball.validation.stress.proved import ProvedTrial
from ghostball.validation.stress.trial import Family, SceneTrial, Suite, Trial


@cache
def trials_of(family: Family, suite: Suite) -> dict[str, Trial]:
    """Return the trials of a family by name; no two have one name."""
    trials = list(family.trials(suite))
    by_name = {trial.name: trial for trial in trials}
    assert len(by_name) == len(trials), f"two trials of {family.name} have one name"
    return by_name


def scene_trial(family: Family, name: str, suite: Suite = "full") -> SceneTrial | ProvedTrial:
    """Return the trial of that name, which is one of a single shot."""
    trial = trials_of(family, suite)[name]
    assert isinstance(trial, SceneTrial | ProvedTrial)
    return trial
