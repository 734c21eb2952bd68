"""The decorator of kernels: who may call one, and what compiling it asks for."""

import sys

import pytest
from kernels import entry_to

from ghostball.engine.core import kernel as jit
from ghostball.engine.event_loop import loop


@pytest.mark.skipif(sys.platform == "win32", reason="counts pages by `getrusage`")
def test_calls_while_compiling_ask_the_system_for_no_memory():
    # At some depth of the stack every call crosses the end of a piece of it. Without the large
    # frame, one of these loops needs a new page for each call.
    import resource

    def pages_of_calls(depth):
        if depth:
            return pages_of_calls(depth - 1)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
        for _ in range(1000):
            nothing(*range(10))
        return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before

    def nothing(*_):
        pass

    most = max(jit._in_one_piece(pages_of_calls, depth) for depth in range(200))
    assert most < 100


@pytest.mark.compiled
def test_a_kernel_without_a_wrapper_refuses_a_call_from_python():
    # Without the refusal the process ends here with a segmentation fault.
    with pytest.raises(TypeError, match="kernel `run` can be called by other kernels only"):
        loop.run()
    # What is called instead does the same, and is kept separate from what other kernels call.
    doubled = jit.kernel(twice)
    with pytest.raises(TypeError, match="kernel `twice`"):
        doubled(1.5)
    assert entry_to(doubled)(1.5) == 3.0
    assert entry_to(entry_to(doubled)) is entry_to(doubled)
    with pytest.raises(TypeError, match="kernel `twice`"):
        jit.kernel(twice)(1.5)


def twice(x):
    return x + x
