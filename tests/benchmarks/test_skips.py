"""A skip that changes a result is reported, and only skips that a scene uses are measured."""

from dataclasses import replace

import numpy as np
import pytest
from shots import POOL_TABLE, ball, scene_of

from benchmarks import skips
from benchmarks.skips import ROUNDING, compare_answers, measure_skips
from ghostball.engine import simulate
from ghostball.engine.running.skips import BUILT_IN, Skip

# No resting contact and no integrated law, so that the kernels are compiled already.
SHOT = scene_of(ball((0.5, 0.6), (1.0, 0.1)), ball((1.2, 0.64)), table=POOL_TABLE)


@pytest.fixture(scope="module")
def shot():
    return simulate(SHOT, record="events")


def with_events(result, change):
    events = result.events.copy()
    change(events)
    return replace(result, events=events)


def test_the_same_run_has_the_same_bits(shot):
    assert compare_answers(shot, simulate(SHOT, record="events")) == ("same bits", "")


def later_by(events, ulps, row=1):
    events["t"][row] += ulps * np.spacing(events["t"][row])


@pytest.mark.parametrize(
    ("change", "verdict"),
    [
        (lambda e: later_by(e, 1), ("rounding", "event 2 of 3: 0.67 roundings")),
        (lambda e: later_by(e, 1.5 * ROUNDING + 1.5), ("differs", "event 2 of 3: 17 roundings")),
        (lambda e: e["b"].__setitem__(0, 3), ("differs", "event 1 of 3: a different event")),
        (lambda e: e["kind"].__setitem__(2, 2), ("differs", "event 3 of 3: a different event")),
    ],
)
def test_an_event_that_moved_is_seen(shot, change, verdict):
    assert len(shot.events) == 3
    assert compare_answers(shot, with_events(shot, change)) == verdict


@pytest.mark.compiled
def test_every_skip_in_use_has_a_row_and_every_other_a_reason():
    measured = measure_skips([SHOT], rounds=2)
    assert not measured.defects
    names = {row.skip for row in measured.rows}
    assert names >= {"air-and-flight", "records"}
    assert measured.unused["test"].keys() | names == set(Skip)
    for skip, why in measured.unused["test"].items():
        assert (why == skips.NOT_MEASURED) == (skip in BUILT_IN)


def test_a_skip_that_changes_the_answer_is_a_defect(monkeypatch):
    """A skip that changes rounding is also a defect, except the one in `ROUNDING_SKIPS`."""
    honest = skips.run

    def planted(scene, *, record="rest", no_skip=()):
        result = honest(scene, record=record)
        off = record == "events" and "air-and-flight" in no_skip
        return with_events(result, lambda e: later_by(e, 1)) if off else result

    monkeypatch.setattr(skips, "run", planted)
    (defect,) = measure_skips([SHOT], rounds=1).defects
    assert (defect.skip, defect.equality) == ("air-and-flight", "differs")
