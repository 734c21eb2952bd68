"""Counts of how often the standard errors of fits hold."""

from __future__ import annotations

import pytest

from benchmarks.fits import TABLES, FitsMeasurement, FittedTable, fitted_table


def table(seed: int, off: float, laws: list[str], program: str = "engine") -> FittedTable:
    return FittedTable(
        seed=seed,
        program=program,
        law="han2005",
        laws_alike=laws,
        rate=25.0,
        noise=1e-3,
        side=0.0,
        events={"rolling": 9},
        goodness=1.0,
        seconds=10.0 * len(laws),
        errors_off={"rolling_friction": off},
    )


MEASURED = FitsMeasurement(
    tables=[
        table(0, 0.5, ["han2005"]),
        table(1, -2.5, ["frictional", "han2005"]),
        table(2, 1.9, ["frictional"]),
        table(3, -1.9, []),
        table(4, 3.0, [], "steps"),
    ]
)


def test_errors_that_hold_are_counted():
    assert MEASURED.rows == [
        ("rolling_friction", "4, by the engine", "75.0 %", "2.5"),
        ("rolling_friction", "1, by another program", "0.0 %", "3.0"),
    ]


def test_the_number_of_tables_stands_beside_that_of_a_whole_measurement():
    assert MEASURED.extent == f"5 tables were fitted; a whole measurement has {TABLES}."


def test_the_results_of_law_searches_are_reported():
    said = MEASURED.law_searches
    assert "In 3 more fits, the law was fitted, too: 1 found only the true law; " in said
    assert "1 found several laws that can't be distinguished, " in said
    assert "at most 20 s" in said
    given = FitsMeasurement(tables=[table(3, -1.9, [])])
    assert given.law_searches == "The cushion law was given."


@pytest.mark.slow
@pytest.mark.parametrize("seed", [21, 101, 107])
def test_the_errors_hold_for_a_table_that_another_program_played(seed):
    """The balls, the nose height and the camera differ from the assumptions of the fit.

    Fails where an assumption that is off isn't part of the error: values were 6 errors off. In
    table 21, straight contacts just slip: near the best fit, errors were too small by seven times.
    """
    found = fitted_table(seed)
    assert found.program == "steps"
    assert found.errors_off.keys() >= {"cushion_restitution", "cushion_friction"}
    assert all(abs(off) < 3.5 for off in found.errors_off.values())


@pytest.mark.slow
def test_a_table_is_fitted_and_nearly_right():
    found = fitted_table(100)
    assert found.laws_alike == []
    assert found.errors_off.keys() >= {"rolling_friction", "cushion_restitution"}
    assert all(abs(off) < 5.0 for off in found.errors_off.values())
    assert 0.7 < found.goodness < 1.4
