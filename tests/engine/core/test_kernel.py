"""The kernel cache: nothing stale is ever used, and old caches go away."""

import ast
import os
import subprocess
import sys
import time
from pathlib import Path
from threading import Thread

import pytest
from copies import copy_packages
from kernels import entry_to

from ghostball import reference_adapters
from ghostball.engine.core import kernel as jit
from ghostball.engine.event_loop import loop

# Two kernels in files of their own beside the engine's, which would take far longer to compile.
CALLEE = """
from ghostball.engine.core.kernel import kernel

@kernel
def grown(x):
    return 2.0 * x
"""
CALLER = """
from ghostball.engine._callee import grown
from ghostball.engine.core.kernel import compiling, kernel

@kernel(entry=True)
def called(x):
    return grown(x) + 1.0

with compiling("calls"):
    print(called(3.0))
"""


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


@pytest.fixture
def copy(tmp_path):
    """A copy of the engine with the two kernels."""
    sources = copy_packages(tmp_path, "engine", bytecode=False) / "engine"
    (sources / "_callee.py").write_text(CALLEE)
    (sources / "_caller.py").write_text(CALLER)
    return tmp_path


def run_copy(folder, cache):
    environment = {**os.environ, "PYTHONPATH": str(folder), "GHOSTBALL_CACHE_DIR": str(cache)}
    done = subprocess.run(
        [sys.executable, "-c", "import ghostball.engine._caller"],
        env=environment,
        cwd=folder,
        capture_output=True,
        text=True,
        check=True,
    )
    return float(done.stdout), done.stderr


@pytest.mark.compiled
def test_an_edited_callee_in_another_file_is_seen(copy):
    """numba alone would go on using the caller's old machine code."""
    cache = copy / "cache"
    first, compiling = run_copy(copy, cache)
    assert first == 7.0
    assert "compiling" in compiling
    again, silent = run_copy(copy, cache)
    assert again == first
    assert "compiling" not in silent  # the cache serves a later process
    (copy / "ghostball/engine/_callee.py").write_text(CALLEE.replace("2.0 * x", "3.0 * x"))
    assert run_copy(copy, cache)[0] == 10.0


@pytest.mark.compiled
def test_a_kernel_without_a_wrapper_refuses_a_call_from_python():
    # Without the refusal the process ends here with a segmentation fault.
    with pytest.raises(TypeError, match="kernel `run` can be called by other kernels only"):
        loop.run()
    # What is called instead does the same, and is kept apart from what other kernels call.
    doubled = jit.kernel(twice)
    with pytest.raises(TypeError, match="kernel `twice`"):
        doubled(1.5)
    assert entry_to(doubled)(1.5) == 3.0
    assert entry_to(entry_to(doubled)) is entry_to(doubled)
    with pytest.raises(TypeError, match="kernel `twice`"):
        jit.kernel(twice)(1.5)


def is_kernel(function):
    decorators = [getattr(one, "func", one) for one in function.decorator_list]
    return any(isinstance(one, ast.Name) and one.id == "kernel" for one in decorators)


def borrowed_by_kernels(source):
    """Return the names that a file's kernels use and that it imports, but from the engine."""
    module = ast.parse(source)
    imported, used = set(), set()
    for node in ast.walk(module):
        if isinstance(node, ast.Import):
            imported |= {(one.asname or one.name) for one in node.names if one.name != "math"}
        elif isinstance(node, ast.ImportFrom) and not (node.module or "").startswith(
            "ghostball.engine"
        ):
            imported |= {one.asname or one.name for one in node.names}
        elif isinstance(node, ast.FunctionDef) and is_kernel(node):
            used |= {one.id for part in node.body for one in ast.walk(part) if hasattr(one, "id")}
    return imported & used


def test_a_kernel_outside_the_engine_uses_what_is_in_its_file_alone():
    """The cache's key has the sources of the engine; of any other file, numba looks at that alone.

    So a kernel that borrows one, or a number, from a file beside it would stay as it is when that
    is edited.
    """
    folder = Path(reference_adapters.__file__).parent
    files = [path for path in folder.rglob("*.py") if "@kernel" in path.read_text("utf-8")]
    assert len(files) >= 2
    for path in files:
        assert borrowed_by_kernels(path.read_text("utf-8")) == set(), path.name
    text = "from ghostball.reports.b import c\n@kernel(entry=True)\ndef f(x):\n    return c(x)\n"
    assert borrowed_by_kernels(text) == {"c"}


def twice(x):
    return x + x


@pytest.mark.compiled
def test_what_two_compile_of_one_kernel_at_once_is_all_kept(monkeypatch, tmp_path):
    """Index and code of two variants were mixed up: neither could be loaded or compiled again."""
    monkeypatch.setattr(jit, "cache_directory", lambda: tmp_path)
    first, second = (jit.kernel(twice)._cache._cache_file for _ in range(2))
    beside = Thread(target=lambda: second.save("second", 2))
    save_index = first._save_index

    def save_index_late(overloads):
        beside.start()
        beside.join(0.5)  # as long as it would take, were it not for the lock
        save_index(overloads)

    monkeypatch.setattr(first, "_save_index", save_index_late)
    first.save("first", 1)
    beside.join()
    assert (first.load("first"), first.load("second")) == (1, 2)


@pytest.mark.parametrize("name", ["get_host_cpu_name", "get_host_cpu_features"])
def test_key_depends_on_the_processor(monkeypatch, name):
    # Where it doesn't, kernels of another processor are called compiled, and compiled in silence.
    key = jit.cache_key()
    other = {"sse2": True} if name == "get_host_cpu_features" else "znver2"
    features = type("Features", (dict,), {"flatten": lambda self: str(dict(self))})
    found = features(other) if name == "get_host_cpu_features" else other
    monkeypatch.setattr(jit.llvmlite.binding, name, lambda: found)
    assert jit.cache_key() != key


@pytest.mark.parametrize("flag", jit.FLAGS)
def test_key_depends_on_flags(monkeypatch, flag):
    key = jit.cache_key()
    assert key == jit.cache_key()
    monkeypatch.setattr(jit._config, flag, 17)
    assert jit.cache_key() != key


def test_old_caches_are_removed_and_recent_ones_kept(tmp_path):
    now = time.time()
    for age in range(16):
        folder = tmp_path / f"cache{age}"
        folder.mkdir()
        (folder / "index").write_text("x")
        os.utime(folder, (now - age, now - age))
    jit._prune(tmp_path, keep=tmp_path / "cache15")
    left = {path.name for path in tmp_path.iterdir()}
    assert left == {"cache15", *(f"cache{age}" for age in range(jit.KEPT_CACHES))}


@pytest.mark.compiled
def test_of_two_processes_one_compiles_and_the_other_waits(copy):
    environment = {**os.environ, "PYTHONPATH": str(copy), "GHOSTBALL_CACHE_DIR": str(copy / "c")}
    command = [sys.executable, "-c", "import ghostball.engine._caller"]
    both = [
        subprocess.Popen(
            command,
            env=environment,
            cwd=copy,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for _ in range(2)
    ]
    said = [process.communicate() for process in both]
    assert [out for out, _ in said] == ["7.0\n", "7.0\n"]
    assert sum("compiling" in messages for _, messages in said) == 1


@pytest.mark.compiled
def test_an_unwritable_cache_is_said_and_does_not_stop_the_run(copy):
    blocked = copy / "file"
    blocked.write_text("")
    found, messages = run_copy(copy, blocked / "cache")
    assert found == 7.0
    assert "GHOSTBALL_CACHE_DIR" in messages
    assert "Traceback" not in messages
