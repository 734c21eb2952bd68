"""How often bounds of model errors hold: what is counted, and that it is enough of them."""

from __future__ import annotations

import pytest

from benchmarks import attribution
from benchmarks.attribution import (
    SUBJECTS,
    AttributedShot,
    AttributionMeasurement,
    Coverage,
    measure_attribution,
    pool_shot,
)
from benchmarks.measurements import STORE, load
from benchmarks.running import BenchError

SHOT = AttributedShot(
    number=3,
    engine="pymunk",
    outcome="attributed",
    difference=5e-3,
    model=2e-3,
    uncertainty=1e-3,
    true_model=1.1e-3,
)


def changed(**changes: object) -> AttributedShot:
    return SHOT.model_copy(update=changes)


def test_a_bound_holds_where_the_true_size_is_within_it() -> None:
    assert SHOT.covered is True
    assert changed(true_model=0.9e-3).covered is False
    assert changed(model=None, uncertainty=None, true_model=None).covered is None


def test_what_has_no_number_counts_as_neither() -> None:
    untold = changed(outcome="not told", model=None, uncertainty=None, true_model=None)
    rows = [SHOT, changed(true_model=0.0), untold, changed(engine="other")]
    rows.append(untold.model_copy(update={"outcome": "not compared"}))
    found = Coverage.of("pymunk", rows)
    assert (found.shots, found.attributed, found.covered) == (4, 2, 1)
    assert (found.not_told, found.not_compared, found.blamed) == (1, 1, 2)
    assert found.relative == 0.2
    assert Coverage.of("nobody", rows).relative is None


def test_shots_are_those_of_their_numbers() -> None:
    assert pool_shot(7) == pool_shot(7)
    assert pool_shot(7) != pool_shot(8)
    assert {len(pool_shot(number).balls) for number in range(40)} == {2, 3, 4, 5}


def test_bounds_hold_on_a_few_shots_of_the_cheapest_engine(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(attribution, "SUBJECTS", SUBJECTS[2:])
    seen: list[tuple[int, int]] = []
    measured = measure_attribution(
        8, first=5_000, jobs=1, progress=lambda done, of, _: seen.append((done, of))
    )
    assert seen[-1] == (8, 8)
    assert [row.number for row in measured.rows] == list(range(5_000, 5_008))
    (coverage,) = measured.engines
    assert coverage.attributed >= 5
    assert coverage.covered == coverage.attributed
    assert not measured.failing


def test_an_interrupt_keeps_what_is_done(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(attribution, "SUBJECTS", SUBJECTS[2:])

    def interrupt(done: int, of: int, last: str) -> None:
        if done == 2:
            raise KeyboardInterrupt

    measured = measure_attribution(3, jobs=1, progress=interrupt)
    assert measured.interrupted
    assert measured.shots == 2
    assert measured.anything


@pytest.mark.parametrize("wrong", [{"shots": 0}, {"first": -1}, {"jobs": 0}])
def test_numbers_that_make_no_sense_are_refused(wrong: dict[str, int]) -> None:
    with pytest.raises(BenchError, match=next(iter(wrong))):
        measure_attribution(**{"shots": 1} | wrong)


@pytest.mark.checkout
def test_what_is_stored_holds_as_often_as_is_claimed() -> None:
    paths = sorted(STORE.glob("*/attribution.json"))
    assert paths
    for path in paths:
        stored = load(path, AttributionMeasurement)
        assert not stored.failing
        assert stored.shots == 200
        assert list(stored.engines) == [
            Coverage.of(one.engine, stored.rows) for one in stored.engines
        ]
