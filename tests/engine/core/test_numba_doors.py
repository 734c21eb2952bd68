"""What the engine uses of numba that numba doesn't promise: each by name, where one of them moves.

`pyproject.toml` bounds numba above for it. Whoever raises the bound runs this first; what fails is
used in `engine/core/kernel.py` or `engine/core/kernel_cache.py`.
"""

import inspect
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

# Module, class, what is called or overridden of it, with the names of the parameters.
METHODS = [
    ("numba.core.codegen", "JITCodeLibrary", "_optimize_final_module", ("self",)),
    ("numba.core.codegen", "JITCodeLibrary", "_finalize_final_module", ("self",)),
    ("numba.core.codegen", "JITCodeLibrary", "_get_module_for_linking", ("self",)),
    ("numba.core.codegen", "JITCodeLibrary", "enable_object_caching", ("self",)),
    ("numba.core.compiler", "Compiler", "compile_extra", ("self", "func")),
    ("numba.core.registry", "CPUDispatcher", "compile", ("self", "sig")),
    ("numba.core.registry", "CPUDispatcher", "get_call_template", ("self", "args", "kws")),
    ("numba.core.caching", "FunctionCache", "__init__", ("self", "py_func")),
    ("numba.core.caching", "FunctionCache", "save_overload", ("self", "sig", "data")),
    ("numba.core.caching", "_CacheLocator", "get_suitable_cache_subpath", ("py_file",)),
    ("numba.core.caching", "_CacheLocator", "from_function", ("py_func", "py_file")),
    ("numba.core.caching", "_CacheLocator", "get_cache_path", ("self",)),
    ("numba.core.caching", "_CacheLocator", "get_source_stamp", ("self",)),
    ("numba.core.caching", "_CacheLocator", "get_disambiguator", ("self",)),
]

# Module, class, and what it keeps under a name that the engine reads or sets.
ATTRIBUTES = [
    ("numba.core.codegen", "CodeLibrary", "_finalized"),
    ("numba.core.codegen", "CPUCodeLibrary", "_final_module"),
    ("numba.core.compiler", "CompilerBase", "self.state.targetctx"),
    ("numba.core.compiler", "CompilerBase", "self.state.library"),
    ("numba.core.dispatcher", "Dispatcher", "_cache"),
    ("numba.core.caching", "Cache", "_impl_class"),
    ("numba.core.caching", "CompileResultCacheImpl", "_locator_classes"),
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


def test_the_names_of_environments_begin_as_they_did():
    from ghostball.engine.core.kernel import _ENVIRONMENT

    source = inspect.getsource(import_module("numba.core.codegen"))
    assert "NumbaEnv" in source + inspect.getsource(import_module("numba.core.funcdesc"))
    assert _ENVIRONMENT.endswith("NumbaEnv")


@pytest.mark.checkout
def test_numba_is_bounded_above():
    text = Path("pyproject.toml").read_text(encoding="utf-8")
    (need,) = (one for one in tomllib.loads(text)["project"]["dependencies"] if "numba" in one)
    assert "<" in need
