"""Tests of the compiler: rejected kernels, the permitted numba, and the stack while compiling."""

import re
import tomllib
from pathlib import Path

import pytest

from ghostball.engine.library import build, processor
from ghostball.engine.library.entry import COMPILED
from ghostball.reference_adapters.stepping import slowing


@pytest.mark.checkout
def test_numba_is_bounded_above():
    text = Path("pyproject.toml").read_text(encoding="utf-8")
    for need in tomllib.loads(text)["project"]["optional-dependencies"]["compiler"]:
        assert re.match(r"numba>=[\d.]+,<[\d.]+;", need)


@pytest.mark.skipif(not COMPILED, reason="interpreted kernels have no libraries")
def test_a_kernel_that_calls_functions_of_numba_is_refused(monkeypatch):
    monkeypatch.setattr(build, "OF_OTHERS", ("hypot",))
    kinds = [["array", "f8", 2], ["array", "f8", 1], ["array", "f8", 1]]
    with pytest.raises(TypeError, match=r"the kernel `stop` calls \['hypot'\]"):
        build.object_code(slowing.stop.function, kinds, processor.target())


def test_calls_while_compiling_ask_the_system_for_no_memory():
    # At some depth, every call crosses the end of a piece of the stack. Without the large frame,
    # each call in one of these loops needs a new page.
    resource = pytest.importorskip("resource", reason="counts pages by `getrusage`")

    def pages_of_calls(depth):
        if depth:
            return pages_of_calls(depth - 1)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
        for _ in range(1000):
            nothing(*range(10))
        return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before

    def nothing(*_):
        pass

    most = max(build._in_one_piece(pages_of_calls, depth) for depth in range(200))
    assert most < 100
