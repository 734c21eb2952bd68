"""Tests of the decorator of kernels: which code may call a kernel, and how."""

from kernels import entry_to

from ghostball.engine.core.kernel import COMPILED, kernel
from ghostball.engine.impacts.laws.friction_curve import friction_coefficient
from ghostball.engine.library.entry import Entry
from ghostball.engine.library.reached import is_inline, kernel_in


def twice(x: float) -> float:
    return x + x


def test_a_kernel_that_only_others_call_stays_a_function():
    assert kernel(twice) is twice
    assert not is_inline(twice)
    assert kernel(inline=True)(twice) is twice
    assert is_inline(twice)
    assert twice(1.5) == 3.0


def test_an_entry_is_called_as_the_function_would_be():
    entry = kernel(entry=True)(twice)
    assert isinstance(entry, Entry)
    assert entry.__name__ == "twice"
    assert kernel_in(entry) is kernel_in(twice) is twice
    assert kernel_in(len) is None


def test_tests_call_inner_kernels_compiled_if_kernels_are():
    assert (entry_to(friction_coefficient) is friction_coefficient) == (not COMPILED)
    assert entry_to(entry_to(friction_coefficient)) is entry_to(friction_coefficient)
