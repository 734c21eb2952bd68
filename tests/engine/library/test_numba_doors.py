"""What the engine uses of numba that numba doesn't promise: each by name, where one of them moves.

`pyproject.toml` bounds numba above for it. Whoever raises the bound runs this first; what fails is
used in `engine/library/build.py`.
"""

import inspect
import re
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

# Module, class, what is called or overridden of it, with the names of the parameters.
METHODS = [
    ("numba.core.codegen", "JITCodeLibrary", "_optimize_final_module", ("self",)),
    ("numba.core.codegen", "JITCodeLibrary", "_finalize_final_module", ("self",)),
    ("numba.core.codegen", "JITCodeLibrary", "_get_module_for_linking", ("self",)),
    ("numba.core.compiler", "Compiler", "compile_extra", ("self", "func")),
    ("numba.core.registry", "CPUDispatcher", "get_call_template", ("self", "args", "kws")),
    ("numba.core.base", "BaseContext", "insert_user_function", ("self", "func", "fndesc", "libs")),
]

# Module, class, and what it keeps under a name that the engine reads or sets.
ATTRIBUTES = [
    ("numba.core.codegen", "CodeLibrary", "_finalized"),
    ("numba.core.codegen", "CPUCodeLibrary", "_final_module"),
    ("numba.core.compiler", "CompilerBase", "self.state.targetctx"),
    ("numba.core.compiler", "CompilerBase", "self.state.library"),
    ("numba.core.typed_passes", "BaseNativeLowering", "flags.no_compile"),
]


@pytest.mark.parametrize(("module", "owner", "method", "parameters"), METHODS)
def test_a_method_is_there_and_takes_the_same(module, owner, method, parameters):
    found = getattr(getattr(import_module(module), owner), method)
    assert tuple(inspect.signature(found).parameters) == parameters


@pytest.mark.parametrize(("module", "owner", "attribute"), ATTRIBUTES)
def test_an_attribute_is_kept_under_its_name(module, owner, attribute):
    found = getattr(import_module(module), owner)
    written = [one for one in found.__mro__ if one.__module__.startswith("numba.")]
    assert attribute in "".join(map(inspect.getsource, written))


@pytest.mark.checkout
def test_numba_is_bounded_above():
    text = Path("pyproject.toml").read_text(encoding="utf-8")
    for need in tomllib.loads(text)["project"]["optional-dependencies"]["compiler"]:
        assert re.match(r"numba>=[\d.]+,<[\d.]+;", need)
