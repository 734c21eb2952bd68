"""The time step of an engine is found, and a series of time steps has the right steps."""

import itertools

import pytest
from pydantic import ValidationError

from ghostball.reference_adapters import make_engine
from ghostball.validation.runs import time_steps
from ghostball.validation.runs.time_steps import (
    MOST_STEPS,
    halved_steps,
    shorter_steps,
    step_in,
    step_of,
    step_setting,
    with_setting,
    with_step,
)


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


def test_the_step_of_a_run_is_in_its_settings():
    assert step_in({"iterations": 3, "dt": 2e-3}) == 2e-3
    assert step_in({"dt": None, "frame": 0.02}) == 0.02
    assert step_in({}) is None


def test_shorter_steps_begin_with_the_engine_s_own():
    assert shorter_steps(make_engine("pymunk:dt=0.016"), 3) == [0.016, 0.004, 0.001]
    assert shorter_steps(make_engine("ghostball"), 3) == []


@pytest.mark.parametrize("own", [1e-3, 0.02, 1 / 240, 0.05, 1e-5])
def test_steps_are_halved_from_the_longest_and_the_own_one_is_among_them(own):
    steps = list(halved_steps(own, 4.0))
    assert own in steps
    assert all(a == 2.0 * b for a, b in itertools.pairwise(steps))
    assert 0.01 < steps[0] <= max(0.02, own)
    assert steps[-1] == own or 4.0 / steps[-1] <= MOST_STEPS


def test_a_ladder_ends_where_it_may(monkeypatch):
    monkeypatch.setattr(time_steps, "MOST_STEPS", 400)
    assert list(halved_steps(0.02, 4.0)) == [0.02, 0.01]
    monkeypatch.setattr(time_steps, "MOST_LEVELS", 1)
    assert list(halved_steps(0.02, 4.0)) == [0.02]
