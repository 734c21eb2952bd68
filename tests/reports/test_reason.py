"""The sentence that an explanation leads with says no more than was compared."""

from __future__ import annotations

from dataclasses import replace

import pytest

from ghostball.model import Scene
from ghostball.reference_adapters.registry import make_engine
from ghostball.reports.reason import reason_of
from ghostball.validation.diagnose.explanation import Explanation, explain
from ghostball.validation.scenes.library import find_scene

STOP: Scene = find_scene("head-on")


@pytest.fixture(scope="module")
def explained() -> Explanation:
    pytest.importorskip("pymunk")
    return explain(STOP, make_engine("pymunk"), label="pymunk")


def test_a_shot_that_was_compared_to_its_end_is_right_but_for_its_step(explained: Explanation):
    assert reason_of(explained).startswith("pymunk is right except for its time step: ")


@pytest.mark.parametrize("outcome", ["agrees", "step"])
def test_of_a_shot_that_was_compared_in_part_the_rest_is_not_called_right(
    explained: Explanation, outcome: str
):
    """Breaks where a break that ends metres off is called right: so it was till it began."""
    assert explained.attribution is not None
    part = replace(explained.attribution, outcome=outcome, instant=0.1, until="collisions differ")
    text = reason_of(replace(explained, attribution=part))
    assert "p to t = 100 ms" in text
    assert "can't be compared: collisions differ" in text
    assert "is right" not in text


def test_a_run_that_is_wrong_on_the_way_is_not_called_right():
    """Breaks where "is right" stands above a curve of 100 mm: only the end was compared."""
    ours = explain(find_scene("half-ball-cut"), make_engine("ghostball"), label="mine")
    assert reason_of(ours).startswith("mine is right: ")
    assert ours.result.events is not None
    events = ours.result.events.copy()
    events["t"][:1] -= 0.01
    text = reason_of(replace(ours, result=replace(ours.result, events=events)))
    assert text.startswith("The final positions of mine are right (")
    assert 'its events have "cue" hits "object" 0.01 s too early' in text
