"""Facts: each table is whole and cited; one that isn't is refused by file, field and rule."""

from __future__ import annotations

import pytest

from ghostball.validation.measured.facts import (
    Facts,
    FactsError,
    Hits,
    facts_of,
    hits_of,
    names_of_facts,
    parsed,
)

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


HITS = """
title = "t"
citation = "somebody, somewhere, some year"
conditions = "on some table, with some balls"
grades = false

[[rows]]
speed = 1.0
cut = 30.0
cue_speed = 0.5
object_speed = 0.6
cue_angle = 33.0
object_angle = 30.0
"""


@pytest.mark.parametrize("name", [name for name in names_of_facts() if "hits" not in name])
def test_each_table_is_read_and_its_bins_rise(name):
    places = [row.at if row.low is None else row.low for row in facts_of(name).rows]
    assert places == sorted(places)


def test_the_hits_keep_what_geometry_and_energy_ask():
    # A number typed wrongly would part the object ball from the line of centres, or make energy.
    hits = hits_of("hits-snooker").rows
    assert len(hits) == 5
    for hit in hits:
        assert hit.object_angle == pytest.approx(hit.cut, abs=0.02)
        assert hit.cue_speed**2 + hit.object_speed**2 < hit.speed**2


def test_a_table_of_another_kind_is_refused():
    with pytest.raises(FactsError, match=r"hits-snooker.toml: quantity: Field required"):
        facts_of("hits-snooker")
    with pytest.raises(FactsError, match=r"rolling-pool.toml: grades: Input should be False"):
        hits_of("rolling-pool")


def test_the_rebounds_are_those_of_the_published_curve():
    for row in facts_of("rebound-snooker").rows:
        assert row.value == pytest.approx(-0.0877 * row.at**2 + 1.131 * row.at - 0.0953, abs=0.0005)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("false", "true", "t.toml: grades: Input should be False"),
        ("speed = 1.0", "speed = 0.0", "t.toml: rows.0.speed: Input should be greater than 0"),
        ("cut = 30.0", "cut = 90.0", "t.toml: rows.0.cut: Input should be less than 90"),
        ("cut = 30.0", "", "t.toml: rows.0.cut: Field required"),
        ("cut = 30.0", "cut = 30.0\nside = 0.0", "t.toml: rows.0.side: Extra inputs"),
    ],
)
def test_a_wrong_table_of_hits_is_refused(old, new, said):
    with pytest.raises(FactsError) as refused:
        parsed(HITS.replace(old, new, 1), "t.toml", Hits)
    assert said in str(refused.value)


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
        parsed(text, "t.toml", Facts)
    assert said in str(refused.value)
