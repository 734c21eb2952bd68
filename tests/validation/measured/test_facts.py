"""Facts: each table is whole and cited; one that isn't is refused by file, field and rule."""

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


def test_a_table_that_is_not_there_is_named():
    with pytest.raises(FactsError, match=r'no facts called "none"; there are .*cushion-carom'):
        facts_of("none")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("title", "titel", "t.toml: title: Field required"),
        ("= 2.0", '= "two"', r"t.toml: rows.0.value: Input should be a valid number"),
        (", error = 0.1", "", "facts that grade need the `error` of each row"),
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
