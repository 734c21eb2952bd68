"""The compiler: what it refuses, and what it uses of numba that numba doesn't promise, by name.

`pyproject.toml` bounds numba above for that. Whoever raises the bound runs this first.
"""

import inspect
import re
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

from ghostball.engine.library import build, generated, processor
from ghostball.engine.library.entry import COMPILED
from ghostball.reference_adapters.stepping import slowing

# Module, class, what is called or overridden of it, with the names of the parameters.
METHODS = [
    ("numba.core.codegen", "JITCodeLibrary", "_optimize_final_module", ("self",)),
    ("numba.core.codegen", "JITCodeLibrary", "_finalize_final_module", ("self",)),
    ("numba.core.codegen", "JITCodeLibrary", "_optimize_functions", ("self", "ll_module")),
    ("numba.core.codegen", "JITCodeLibrary", "finalize", ("self",)),
    ("numba.core.codegen", "JITCPUCodegen", "_function_pass_manager", ("self", "kwargs")),
    ("numba.core.codegen", "JITCodeLibrary", "_get_module_for_linking", ("self",)),
    ("numba.core.compiler", "Compiler", "compile_extra", ("self", "func")),
    ("numba.core.registry", "CPUDispatcher", "get_call_template", ("self", "args", "kws")),
    ("numba.core.base", "BaseContext", "insert_user_function", ("self", "func", "fndesc", "libs")),
    ("numba.core.base", "BaseContext", "mangler", ("self", "name", "types", "abi_tags", "uid")),
    ("numba.core.funcdesc", "", "default_mangler", ("name", "argtypes", "abi_tags", "uid")),
    (
        "numba.core.types.functions",
        "BaseFunction",
        "get_call_type",
        ("self", "context", "args", "kws"),
    ),
    ("numba.core.cgutils", "", "alloca_once_value", ("builder", "value", "name", "zfill")),
    ("numba.core.cgutils", "", "for_range", ("builder", "count", "start", "intp")),
    (
        "numba.np.arrayobj",
        "",
        "populate_array",
        ("array", "data", "shape", "strides", "itemsize", "meminfo", "parent"),
    ),
]

# Module, class, and what it keeps under a name that the engine reads or sets.
ATTRIBUTES = [
    ("numba.core.codegen", "CodeLibrary", "_finalized"),
    ("numba.core.codegen", "CPUCodeLibrary", "_final_module"),
    ("numba.core.codegen", "CPUCodeLibrary", "_linking_libraries"),
    ("numba.core.codegen", "CPUCodeLibrary", "ll_module.data_layout = self._codegen._data_layout"),
    ("numba.core.compiler", "CompilerBase", "self.state.targetctx"),
    ("numba.core.compiler", "CompilerBase", "self.state.library"),
    ("numba.core.typed_passes", "BaseNativeLowering", "flags.no_compile"),
    ("numba.core.funcdesc", "FunctionDescriptor", "llvm_func_name"),
    ("numba.core.compiler_lock", "", "global_compiler_lock"),
    ("numba.core.cgutils", "_StructProxy", "_getvalue"),
    ("numba.np.arrayobj", "", "numba_attempt_nocopy_reshape"),
    ("numba.core.compiler", "", "entry_point"),
    ("numba.core.compiler", "Flags", "no_cfunc_wrapper"),
    ("numba.core.compiler", "Flags", "no_cpython_wrapper"),
    ("numba.core.compiler", "Flags", "nrt"),
]


MOVED = (
    f"numba moved what {Path(build.__file__).name} or {Path(generated.__file__).name} relies on: "
    "change it there, or keep numba bounded below this version in pyproject.toml"
)


def owner_of(module, name):
    """The module itself, or a class of it."""
    found = import_module(module)
    assert not name or hasattr(found, name), f"{MOVED} (`{module}.{name}` is gone)"
    return getattr(found, name) if name else found


@pytest.mark.parametrize(("module", "owner", "method", "parameters"), METHODS)
def test_a_method_is_there_and_takes_the_same(module, owner, method, parameters):
    found = getattr(owner_of(module, owner), method, None)
    assert found is not None, f"{MOVED} (`{method}` is gone)"
    assert tuple(inspect.signature(found).parameters) == parameters, MOVED


@pytest.mark.parametrize(("module", "owner", "attribute"), ATTRIBUTES)
def test_an_attribute_is_kept_under_its_name(module, owner, attribute):
    found = owner_of(module, owner)
    written = [found]
    if owner:
        written = [one for one in found.__mro__ if one.__module__.startswith("numba.")]
    assert attribute in "".join(map(inspect.getsource, written)), MOVED


@pytest.mark.checkout
def test_numba_is_bounded_above():
    text = Path("pyproject.toml").read_text(encoding="utf-8")
    for need in tomllib.loads(text)["project"]["optional-dependencies"]["compiler"]:
        assert re.match(r"numba>=[\d.]+,<[\d.]+;", need)


@pytest.mark.skipif(not COMPILED, reason="interpreted kernels have no libraries")
def test_a_kernel_that_needs_what_is_numbas_alone_is_refused(monkeypatch):
    monkeypatch.setattr(build, "OF_OTHERS", ("hypot",))
    kinds = [["array", "f8", 2], ["array", "f8", 1], ["array", "f8", 1]]
    with pytest.raises(TypeError, match=r"the kernel `stop` calls \['hypot'\]"):
        build.object_code(slowing.stop.function, kinds, "none", processor.target())


def test_calls_while_compiling_ask_the_system_for_no_memory():
    # At some depth of the stack every call crosses the end of a piece of it. Without the large
    # frame, one of these loops needs a new page for each call.
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
