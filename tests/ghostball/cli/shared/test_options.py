"""Values of options: the same as those of what they are handed to."""

from __future__ import annotations

from typing import get_args

import pytest

from ghostball.cli.shared.options import FailOnChoice
from ghostball.validation.baselines.regression import FailOn


def test_what_fails_a_gate_is_asked_for_as_comparisons_know_it():
    assert {choice.value for choice in FailOnChoice} == set(get_args(FailOn))


@pytest.mark.parametrize(("text", "jobs"), [("auto", 7), ("3", 3)])
def test_jobs_are_a_number_or_all_processors(monkeypatch, text, jobs):
    from ghostball.cli.shared.options import processors

    monkeypatch.setattr("ghostball.cli.shared.options.processor_count", lambda: 7)
    assert processors(text) == jobs


def test_the_shell_completes_scenes_tags_and_engines():
    from ghostball.cli.shared.options import complete_engine, complete_scene

    assert complete_scene("half-ball-c") == ["half-ball-cut"]
    assert "smoke" in complete_scene("smo")
    assert complete_engine("pym") == ["pymunk"]
