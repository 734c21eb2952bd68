"""The step of an engine, by whichever name it has it."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.runs.steps import step_of, step_setting, with_setting, with_step


@pytest.mark.parametrize(
    ("label", "name"),
    [
        ("ghostball", None),
        ("pymunk", "dt"),
        ("paper-discrete", "dt"),
        ("paper-continuous", "frame"),
    ],
)
def test_an_engine_has_its_step_by_name_or_none(label, name):
    assert step_setting(make_engine(label)) == name


@pytest.mark.parametrize("label", ["pymunk:contact_steps=exact", "paper-continuous"])
def test_an_engine_at_another_step_is_else_the_same(label):
    engine = make_engine(label)
    name = step_setting(engine)
    other = with_step(engine, 0.005)
    assert type(other) is type(engine)
    assert other.settings.model_dump() == engine.settings.model_dump() | {name: 0.005}


def test_a_setting_that_is_not_there_or_breaks_its_rule_is_refused():
    with pytest.raises(ValidationError):
        with_step(make_engine("pymunk"), -1.0)
    with pytest.raises(ValidationError):
        with_setting(make_engine("ghostball"), "dt", 1.0)


@pytest.mark.parametrize(
    ("label", "step"),
    [
        ("ghostball", None),
        ("pymunk", 1e-3),
        ("pymunk:contact_steps=exact", 0.02),
        ("pymunk:dt=2e-3", 2e-3),
        ("paper-continuous", 0.02),
    ],
)
def test_a_step_that_is_left_out_is_the_one_that_it_stands_for(label, step):
    assert step_of(make_engine(label)) == step
