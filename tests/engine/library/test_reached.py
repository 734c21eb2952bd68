"""Tests of everything that determines the machine code of a kernel, and of its hash."""

import sys
from types import ModuleType

import numpy as np
import pytest

from ghostball.engine.core.kernel import kernel
from ghostball.engine.event_loop.play import play
from ghostball.engine.library.reached import reached_by
from ghostball.engine.resting_contact import step
from ghostball.reference_adapters.stepping import slowing

CALLEE = """
from ghostball.engine.core.kernel import kernel
LIMIT = 2.0
TABLE = {table}

@kernel
def grown(x):
    # {comment}
    return {expression}

@kernel
def unused(x):
    return {unused}
"""
CALLER = """
from ghostball.engine.core.kernel import kernel
from ghostball import _reached_callee as below
from ghostball._reached_callee import grown

@kernel(entry=True)
def called(x):
    return grown(x) + below.LIMIT + below.grown(x)
"""
AS_IT_IS = {"table": "(1, 2)", "comment": "", "expression": "2.0 * x", "unused": "x"}


@pytest.fixture
def digest_of(monkeypatch):
    """Return the hash of a kernel whose callee, in another module, has these texts."""

    def module(name, source):
        made = ModuleType(f"ghostball.{name}")
        monkeypatch.setitem(sys.modules, made.__name__, made)
        monkeypatch.setattr(sys.modules["ghostball"], name, made, raising=False)
        exec(source, vars(made))
        return made

    def digest(caller=CALLER, limit="2.0", **texts):
        source = CALLEE.format(**AS_IT_IS | texts).replace("LIMIT = 2.0", f"LIMIT = {limit}")
        module("_reached_callee", source)
        return reached_by(module("_reached_caller", caller).called.function).digest

    return digest


def test_the_digest_depends_on_all_reached_code(digest_of):
    before = digest_of()
    assert digest_of() == before
    assert digest_of(expression="3.0 * x") != before
    assert digest_of(limit="2.5") != before
    assert digest_of(CALLER.replace("grown(x) + b", "b")) != before


def test_the_digest_depends_on_nothing_else(digest_of):
    before = digest_of()
    assert digest_of(comment="said in other words\n    # and on two lines") == before
    assert digest_of(unused="7.0 * x") == before
    assert digest_of(table="(3, 4)") == before  # no kernel uses this name
    assert (
        digest_of(CALLER.replace("def called(x):", "def called(x):\n    '''Say it.'''")) == before
    )


def test_the_digest_depends_on_constants_of_any_type(digest_of):
    caller = CALLER.replace("below.LIMIT", "below.TABLE[0]")
    seen = {
        digest_of(caller, table=table)
        for table in ("(1, 2)", "(1, 3)", "(1.0, 2)", "__import__('numpy').arange(2)")
    }
    assert len(seen) == 4


def test_the_digest_depends_on_inlining():
    @kernel
    def one(x):
        return x

    before = reached_by(one).digest
    kernel(inline=True)(one)
    assert reached_by(one).digest != before


def test_what_is_not_constant_is_refused(digest_of):
    caller = CALLER.replace("below.LIMIT", "below.TABLE[0]")
    with pytest.raises(TypeError, match=r"uses `below.TABLE`, which isn't known to be constant"):
        digest_of(caller, table="{1: 2}")
    factor = 2.0

    @kernel
    def closed(x):
        return factor * x

    with pytest.raises(TypeError, match="defined inside another function"):
        reached_by(closed)

    @kernel
    def left_out(x=2.0):
        return x

    with pytest.raises(TypeError, match="has optional arguments"):
        reached_by(left_out)


def test_shots_reach_the_kernels_of_contacts_and_adapters_none_of_them():
    shots = reached_by(play.function).functions
    assert len(shots) > 300
    assert {one.__module__ for one in shots} >= {step.__name__}
    names = {one.__name__ for one in reached_by(slowing.stop.function).functions}
    assert names == {"stop", "_duration"}
    assert np.all([one.__module__.startswith("ghostball.") for one in shots])
