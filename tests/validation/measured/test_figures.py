"""Families of figures: their differences from measurements, and the text for unsupported ones."""

from __future__ import annotations

import pytest
from pydantic import ValidationError
from table_agreements import family, likeness

from ghostball.model import EngineFailedError, UnsupportedSceneError
from ghostball.reference_adapters import make_engine
from ghostball.validation.measured.facts import facts_of
from ghostball.validation.measured.figures import (
    ComparedFigure,
    FigureFamily,
    TableAgreement,
    families_in,
)
from ghostball.validation.measured.simulated_ball import OperatorError
from ghostball.validation.measured.table_agreement import MeasuredEngine, families_of


def with_figures(name: str, error: float | None) -> FigureFamily:
    (found,) = families_in(facts_of(name))
    figures = [ComparedFigure(at=1.0, value=0.5, error=error, played=x) for x in (0.48, 0.49)]
    return found.model_copy(update={"figures": tuple(figures)})


def test_a_family_says_what_its_facts_say_but_for_what_its_heading_says():
    facts = facts_of("cushion-carom")
    ratio, slope = families_in(facts)
    assert (ratio.title, ratio.unit, ratio.grades) == (facts.title, "1", True)
    assert (slope.against, slope.unit) == (facts.against, "s/m")
    assert facts.quantity in slope.quantity
    (shown,) = families_in(facts_of("cushion-snooker"))
    assert shown.grades is False
    assert "don't grade" in shown.conditions


def test_figures_with_errors_are_off_by_standard_errors():
    found = with_figures("banks-pool", 0.01)
    assert [one.errors_off for one in found.figures] == pytest.approx([-2.0, -1.0])
    assert found.typical == pytest.approx(2.5**0.5)
    assert found.most == pytest.approx(2.0)


@pytest.mark.parametrize(("error", "known"), [(0.0101, True), (0.0099, False), (None, None)])
def test_two_standard_errors_are_within_what_is_known(error, known):
    assert with_figures("banks-pool", error).is_within_known is known


def test_figures_without_errors_are_off_in_their_unit_and_by_nothing_else():
    found = with_figures("cushion-snooker", None)
    assert found.typical_difference == pytest.approx(0.00025**0.5)
    with pytest.raises(ValueError, match="this measurement has no standard error"):
        _ = found.typical
    with pytest.raises(ValueError, match="only a `difference`"):
        _ = found.most


@pytest.mark.parametrize(
    ("error", "said", "failed"),
    [
        (
            UnsupportedSceneError("somebody", ("no friction", "no air")),
            "it has no friction; no air",
            False,
        ),
        (EngineFailedError("somebody", "lost the balls"), "it failed: lost the balls", True),
        (OperatorError("a ball rests"), "a ball rests", False),
    ],
)
def test_what_an_engine_lacks_or_that_it_failed_stands_for_its_figures(error, said, failed):
    def play(scene):
        raise error

    for found in families_of("hits-snooker", MeasuredEngine(make_engine("ghostball"), play)):
        assert (found.lacks, found.failed) == (said, failed)
        assert found.figures == ()
        assert found.settings == {}


def test_an_engine_as_a_whole_is_where_it_is_furthest_off_of_what_grades():
    graded = likeness("any", rebound=-2.0, slope=1.0, rolling="it rolls none")
    assert graded.typical == pytest.approx(2.0)
    shown = family("shown", 9.0, grades=False)
    assert TableAgreement(label="any", families=(*graded.families, shown)).typical == graded.typical
    assert likeness("any", rolling="it rolls none").typical is None


@pytest.mark.parametrize("fields", [{"figures": ()}, {"lacks": "it rolls none"}])
def test_a_family_of_an_engine_has_figures_or_says_why_not(fields):
    wrong = family("rolling", 1.0).model_copy(update=fields)
    with pytest.raises(ValidationError, match="must have either `figures` or, in `lacks`"):
        TableAgreement(label="any", families=(wrong,))


def test_what_grades_has_errors():
    """Fails if an edited record is refused only while a page is being written."""
    known = family("rolling", 1.0)
    unknown = tuple(one.model_copy(update={"error": None}) for one in known.figures)
    wrong = known.model_copy(update={"figures": unknown})
    with pytest.raises(ValidationError, match=r"if it `grades`, each of its `figures` must"):
        TableAgreement(label="any", families=(wrong,))
    TableAgreement(label="any", families=(wrong.model_copy(update={"grades": False}),))
