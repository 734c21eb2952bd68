"""What holds of every family."""

from __future__ import annotations

import pytest

from validation.stress.families import FAMILIES


@pytest.mark.parametrize("suite", ["quick", "full"])
@pytest.mark.parametrize("name", FAMILIES)
def test_names_are_unique(name, suite):
    names = [trial.name for trial in FAMILIES[name].trials(suite)]
    assert len(names) == len(set(names)) > 0
