"""Facts: each table is complete and cited; an error names the file, the field and the rule."""

from __future__ import annotations

import pytest

from ghostball.validation.measured.facts import FactsError, facts_of, names_of_facts, parsed

TABLE = """
title = "t"
quantity = "q"
unit = "1"
against = "a"
citation = "somebody, somewhere, some year"
conditions = "on some table, with some balls"
grades = true
rows = [{ at = 1.0, value = 2.0, error = 0.1 }]
"""


@pytest.mark.parametrize("name", names_of_facts())
def test_each_table_is_read_and_its_bins_rise(name):
    places = [row.at if row.low is None else row.low for row in facts_of(name).rows]
    assert places == sorted(places)


def test_a_name_that_is_not_there_is_refused_with_those_that_are():
    with pytest.raises(FactsError, match=r'no facts called "none". Known facts: .*cushion-carom'):
        facts_of("none")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("title", "titel", "t.toml: title: Field required"),
        ("= 2.0", '= "two"', r"t.toml: rows.0.value: Input should be a valid number"),
        (", error = 0.1", "", "facts that grade need the `error` of each row, or several"),
        ("value = 2.0", "value = 2.0, of_each = [1.0, 2.0]", "`value` and `spread` follow from"),
        ("value = 2.0", "of_each = [1.0]", "`of_each` must be a list of two numbers or more"),
        ("value = 2.0", 'of_each = [1.0, "2"]', "`of_each` must be a list of two numbers"),
        ("value = 2.0", "of_each = [1.0, 2.0]", "in `of_each` one figure for each of the `tables`"),
        (
            "value = 2.0",
            "value = 2.0, given = { v = 1.0 }",
            "exactly the quantities that `given` lists",
        ),
        ("grades", "given = { v = 'speed' }\ngrades", "exactly the quantities that `given` lists"),
        ("= 0.1 }", "= 0.1, also = { v = 1.0 } }", "exactly the quantities that `also` lists"),
        (
            "value = 2.0",
            "value = 2.0, count = 1, of = 2",
            "`value` and `error` follow",
        ),
        ("value = 2.0, error = 0.1", "count = 3, of = 2", "whole numbers, 0 <= count <= of"),
        ("value = 2.0, error = 0.1", "count = 1", "whole numbers, 0 <= count <= of"),
        ("at = 1.0, ", "", "a row needs `at`, or `low` and `high`"),
        ("at = 1.0, ", "low = 1.0, ", "a row needs `at`, or `low` and `high`"),
        ("at = 1.0, ", "low = 1.0, high = 0.5, ", "a row needs `low` below `high`"),
        ("at = 1.0, ", "at = 1.0, low = 1.5, high = 2.0, ", "and `at` between them"),
        ('"a"', '"a', "t.toml: not TOML"),
        ("somebody, somewhere, some year", "me", "t.toml: citation"),
    ],
)
def test_a_wrong_table_is_refused(old, new, said):
    text = TABLE.replace(old, new, 1)
    with pytest.raises(FactsError) as refused:
        parsed(text, "t.toml")
    assert said in str(refused.value)


def test_what_has_no_error_does_not_grade():
    also = "also = { v = { quantity = 'speed', unit = 'm/s' } }\ngrades"
    text = TABLE.replace("grades", also).replace("= 0.1 }", "= 0.1, also = { v = 1.0 } }")
    with pytest.raises(FactsError, match="facts that grade have no `also`"):
        parsed(text, "t.toml")
    (row,) = parsed(text.replace("true", "false"), "t.toml").rows
    assert row.also == {"v": 1.0}


def test_errors_of_measurement_and_spread_of_tables_add_as_squares():
    (row,) = parsed(TABLE.replace("error = 0.1", "error = 0.3, spread = 0.4"), "t.toml").rows
    assert row.uncertainty == pytest.approx(0.5)


def test_a_share_follows_from_counts_and_inputs_add_to_its_error():
    text = TABLE.replace("value = 2.0, error = 0.1", "count = 80, of = 100, inputs = 0.03")
    (row,) = parsed(text, "t.toml").rows
    assert (row.value, row.error) == (0.8, pytest.approx(0.04, rel=0.02))
    assert row.uncertainty == pytest.approx(0.05, rel=0.02)


def test_mean_and_spread_of_tables_are_computed():
    (row,) = parsed(
        TABLE.replace("value = 2.0, error = 0.1", "of_each = [1.0, 2.0, 6.0]").replace(
            "grades", "tables = ['a', 'b', 'c']\ngrades"
        ),
        "t.toml",
    ).rows
    assert row.value == 3.0
    assert row.spread == row.uncertainty == pytest.approx(7.0**0.5)


def test_rebounds_of_snooker_are_those_of_the_published_curve():
    for row in facts_of("cushion-snooker").rows:
        assert row.at is not None
        assert row.value == pytest.approx(-0.0877 * row.at**2 + 1.131 * row.at - 0.0953, abs=5e-5)
