"""What holds of every family."""

from __future__ import annotations

import pytest
from stress_trials import trials_of

from ghostball.validation.stress.families import FAMILIES


@pytest.mark.parametrize("suite", ["quick", "full"])
@pytest.mark.parametrize("name", FAMILIES)
def test_names_are_unique(name, suite):
    assert trials_of(FAMILIES[name], suite)
