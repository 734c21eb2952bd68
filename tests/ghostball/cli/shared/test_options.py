"""Values of options: the same as those of what they are handed to."""

from __future__ import annotations

from typing import get_args

from ghostball.cli.shared.options import FailOnChoice
from ghostball.validation.baselines.regression import FailOn


def test_what_fails_a_gate_is_asked_for_as_comparisons_know_it():
    assert {choice.value for choice in FailOnChoice} == set(get_args(FailOn))
