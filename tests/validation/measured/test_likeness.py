"""How like a real table engines can be: every family, and what each engine lacks."""

from __future__ import annotations

from functools import partial

import pytest

from ghostball.reference_adapters import make_engine
from ghostball.validation.measured.likeness import Family, likeness

GRADED = ["cushion", "cushion-slope", "rolling-pool", "banks-pool"]
SHOWN = ["cushion-snooker", "hit-speeds", "hit-angle", "throw-pool"]


def likeness_of(spec: str) -> dict[str, Family]:
    engine = make_engine(spec)
    found = likeness(spec, engine, partial(engine.simulate, record="trajectory"))
    return {family.name: family for family in found.families}


def test_our_engine_plays_everything_that_was_measured():
    families = likeness_of("ghostball")
    assert list(families) == GRADED + SHOWN
    assert [name for name, one in families.items() if one.grades] == GRADED
    assert not any(family.lacks for family in families.values())


def test_an_engine_that_only_rolls_lacks_it_all():
    families = likeness_of("paper-discrete")
    assert families["cushion"].lacks == "it has no law of cushions that turns balls"
    assert families["rolling-pool"].lacks.startswith("it has no sliding that turns into rolling")
    assert not any(family.figures for family in families.values())


@pytest.mark.parametrize("spec", ["ghostball.validation.examples.stepper:Stepper"])
def test_an_engine_that_mentions_few_features_lacks_the_others(spec):
    families = likeness_of(spec)
    assert all(family.lacks for family in families.values())
