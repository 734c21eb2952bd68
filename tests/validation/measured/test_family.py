"""Families of figures: how far off they are, and what stands for those that an engine lacks."""

from __future__ import annotations

import pytest
from likenesses import family, likeness
from pydantic import ValidationError

from ghostball.model import EngineFailedError, UnsupportedSceneError
from ghostball.validation.measured.facts import facts_of
from ghostball.validation.measured.family import Likeness, Measured, family_of
from ghostball.validation.measured.play import OperatorError

GRADED = family_of(facts_of("banks-pool"), "banks-pool", "bank")
SHOWN = family_of(facts_of("cushion-snooker"), "cushion-snooker", "snooker rebound")


def figures(error: float | None) -> tuple[Measured, ...]:
    return tuple(Measured(at=1.0, value=0.5, error=error, played=x) for x in (0.48, 0.49))


def test_a_family_says_what_its_facts_say_but_for_what_is_given():
    facts = facts_of("banks-pool")
    assert (GRADED.title, GRADED.unit, GRADED.grades) == (facts.title, "diamonds", True)
    assert SHOWN.grades is False
    assert "doesn't grade" in SHOWN.conditions
    assert family_of(facts, "a", "b", unit="m").unit == "m"


def test_figures_with_errors_are_off_by_standard_errors():
    found = GRADED.played({"a": 1.0}, lambda: figures(0.01))
    assert [one.errors_off for one in found.figures] == pytest.approx([-2.0, -1.0])
    assert found.typical == pytest.approx(2.5**0.5)
    assert found.most == pytest.approx(2.0)
    assert found.settings == {"a": 1.0}


def test_figures_without_errors_are_off_in_their_unit_and_by_nothing_else():
    found = SHOWN.played({}, lambda: figures(None))
    assert found.typical_difference == pytest.approx(0.00025**0.5)
    with pytest.raises(ValueError, match="no standard error of this figure is known"):
        _ = found.typical
    with pytest.raises(ValueError, match="it has a `difference`"):
        _ = found.most


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (
            UnsupportedSceneError("somebody", ("no friction", "no air")),
            "it has no friction; no air",
        ),
        (EngineFailedError("somebody", "lost the balls"), "it failed: lost the balls"),
        (OperatorError("a ball rests"), "a ball rests"),
    ],
)
def test_what_an_engine_lacks_stands_for_its_figures(error, said):
    def play():
        raise error

    found = GRADED.played({"a": 1.0}, play)
    assert found.lacks == said
    assert found.figures == ()
    assert found.settings == {}


def test_what_failed_is_told_from_what_is_lacking():
    def play():
        raise EngineFailedError("somebody", "lost the balls")

    assert GRADED.played({}, play).failed
    assert not GRADED.lacking("it rolls none").failed
    assert not GRADED.played({}, lambda: figures(0.01)).failed


def test_an_engine_as_a_whole_is_where_it_is_furthest_off_of_what_grades():
    graded = likeness("any", rebound=-2.0, slope=1.0, rolling="it rolls none")
    assert graded.typical == pytest.approx(2.0)
    shown = family("shown", 9.0, grades=False)
    assert Likeness(label="any", families=(*graded.families, shown)).typical == graded.typical
    assert likeness("any", rolling="it rolls none").typical is None


@pytest.mark.parametrize("fields", [{"figures": ()}, {"lacks": "it rolls none"}])
def test_a_family_of_an_engine_has_figures_or_says_why_not(fields):
    wrong = family("rolling", 1.0).model_copy(update=fields)
    with pytest.raises(ValidationError, match="must either have `figures` or say what is lacking"):
        Likeness(label="any", families=(wrong,))


def test_what_grades_has_errors():
    """Breaks where a record that somebody edited is refused by a page alone, half made."""
    known = family("rolling", 1.0)
    unknown = tuple(one.model_copy(update={"error": None}) for one in known.figures)
    wrong = known.model_copy(update={"figures": unknown})
    with pytest.raises(ValidationError, match=r"where it `grades`, each of its `figures` must"):
        Likeness(label="any", families=(wrong,))
    Likeness(label="any", families=(wrong.model_copy(update={"grades": False}),))
