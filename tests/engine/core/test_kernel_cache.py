"""The kernel cache: nothing stale is ever used, old caches go, and nothing else does."""

import ast
import os
import subprocess
import sys
import time
from pathlib import Path
from threading import Thread
from types import ModuleType, SimpleNamespace

import pytest
from copies import copy_packages

from ghostball import engine
from ghostball.engine.core import kernel_cache
from ghostball.engine.core.kernel_cache import KEPT_CACHES, UNUSED, KernelCache

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


@pytest.fixture
def copy(tmp_path):
    """A copy of the engine with the two kernels."""
    sources = copy_packages(tmp_path, "engine") / "engine"
    (sources / "_callee.py").write_text(CALLEE)
    (sources / "_caller.py").write_text(CALLER)
    return tmp_path


def run_copy(folder, cache, module="ghostball.engine._caller"):
    environment = {**os.environ, "PYTHONPATH": str(folder), "GHOSTBALL_CACHE_DIR": str(cache)}
    done = subprocess.run(
        [sys.executable, "-c", f"import {module}"],
        env=environment,
        cwd=folder,
        capture_output=True,
        text=True,
        check=True,
    )
    return float(done.stdout), done.stderr


@pytest.mark.compiled
def test_an_edited_callee_in_another_file_is_seen(copy):
    """numba alone would continue using the caller's old machine code."""
    cache = copy / "cache"
    first, compiling = run_copy(copy, cache)
    assert first == 7.0
    assert "compiling" in compiling
    (copy / "ghostball/engine/_callee.py").write_text(CALLEE.replace("2.0 * x", "3.0 * x"))
    assert run_copy(copy, cache)[0] == 10.0


def twice(x):
    return x + x


@pytest.mark.compiled
def test_what_two_compile_of_one_kernel_at_once_is_all_kept(monkeypatch, tmp_path):
    """Index and code of two variants were mixed up: neither could be loaded or compiled again."""
    first, second = (KernelCache(twice, tmp_path / "key", "inner") for _ in range(2))
    for one in (first, second):  # what stands for types and code
        monkeypatch.setattr(one, "_index_key", lambda signature, codegen: signature)
        monkeypatch.setattr(one._impl, "check_cachable", lambda code: True)
        monkeypatch.setattr(one._impl, "reduce", lambda code: code.number)
    beside = Thread(
        target=lambda: second.save_overload("second", SimpleNamespace(number=2, codegen=0))
    )
    save_index = first._cache_file._save_index

    def save_index_late(overloads):
        beside.start()
        beside.join(0.5)  # as long as it would take, were it not for the lock
        save_index(overloads)

    monkeypatch.setattr(first._cache_file, "_save_index", save_index_late)
    first.save_overload("first", SimpleNamespace(number=1, codegen=0))
    beside.join()
    assert [first._cache_file.load(name) for name in ("first", "second")] == [1, 2]


@pytest.mark.parametrize("name", ["get_host_cpu_name", "get_host_cpu_features"])
def test_key_depends_on_the_processor(monkeypatch, name):
    # Where it doesn't, kernels of another processor are called compiled, and compiled in silence.
    key = kernel_cache.cache_key()
    other = {"sse2": True} if name == "get_host_cpu_features" else "znver2"
    features = type("Features", (dict,), {"flatten": lambda self: str(dict(self))})
    found = features(other) if name == "get_host_cpu_features" else other
    monkeypatch.setattr(kernel_cache.llvmlite.binding, name, lambda: found)
    assert kernel_cache.cache_key() != key


@pytest.mark.parametrize("flag", kernel_cache.FLAGS)
def test_key_depends_on_flags(monkeypatch, flag):
    key = kernel_cache.cache_key()
    assert key == kernel_cache.cache_key()
    monkeypatch.setattr(kernel_cache.numba.config, flag, 17)
    assert kernel_cache.cache_key() != key


def test_key_depends_on_what_kernels_take_from_the_model(monkeypatch, tmp_path):
    file = tmp_path / "events.py"
    file.write_text("BALL_BALL = 0")
    module = ModuleType("events")
    module.__file__ = str(file)
    monkeypatch.setattr(kernel_cache, "FROM_MODEL", (module,))
    key = kernel_cache.cache_key()
    file.write_text("BALL_BALL = 7")
    assert kernel_cache.cache_key() != key


def test_kernels_take_nothing_else_from_the_model():
    """Edited, a constant of a module that isn't in the key would stay in the machine code."""
    allowed = {module.__name__ for module in kernel_cache.FROM_MODEL}
    unread = [path for path in PACKAGE.rglob("*.py") if "kernel" in imported_by(path)]
    assert len(unread) > 40
    read = set()
    while unread:
        path = unread.pop()
        read.add(path)
        for name in imported_by(path).values():
            if name.startswith("ghostball.model"):
                assert any(f"{name}.".startswith(f"{one}.") for one in allowed), (path, name)
            beside = file_of(name)
            if beside is not None and beside not in read:
                unread.append(beside)


PACKAGE = Path(engine.__file__).parent


def imported_by(path):
    """Names that a module imports from ours as it is loaded, and in full what each stands for."""
    loaded = ast.parse(path.read_text()).body
    return {
        alias.asname or alias.name: f"{node.module}.{alias.name}"
        for node in loaded
        if isinstance(node, ast.ImportFrom) and node.module.startswith("ghostball.")
        for alias in node.names
    }


def file_of(name):
    """The file of the engine that a name comes from, or None."""
    parts = name.split(".")
    if parts[:2] != ["ghostball", "engine"]:
        return None
    for end in (len(parts), len(parts) - 1):
        place = PACKAGE.joinpath(*parts[2:end])
        for file in (place.with_suffix(".py"), place / "__init__.py"):
            if file.is_file():
                return file
    raise AssertionError(name)


def cache_of(root, number, age=0.0, marker=kernel_cache._MARKED):
    """Make a cache, as one is that was last used some seconds ago."""
    folder = root / f"{number:020x}"
    (folder / "inner").mkdir(parents=True)
    (folder / "inner" / "index").write_text("x")
    if marker:
        (folder / "CACHEDIR.TAG").write_bytes(marker)
    used = time.time() - age  # of now: tests may be collected long before they run
    os.utime(folder, (used, used))
    return folder


def names(folder):
    return {path.name for path in folder.iterdir()}


def test_old_caches_are_removed_and_those_used_last_kept(tmp_path):
    folders = [cache_of(tmp_path, age, (age + 2) * UNUSED) for age in range(KEPT_CACHES + 4)]
    kernel_cache._prune(tmp_path)
    left = {path.name for path in folders[: KEPT_CACHES + 1]}
    assert names(tmp_path) - {"kernels.lock"} == left


def test_what_is_not_ours_is_never_removed(tmp_path):
    """The first use removed whatever folders the user had in what GHOSTBALL_CACHE_DIR named."""
    old = 1000 * UNUSED
    for age in range(KEPT_CACHES + 4):
        cache_of(tmp_path, age)
    theirs = [
        cache_of(tmp_path, 0x100, old, marker=None),
        cache_of(tmp_path, 0x101, old, marker=b"Signature: 8a477f597d28d172789f06886806bc55\n"),
        cache_of(tmp_path, 0x102, old).rename(tmp_path / "thesis"),
        cache_of(tmp_path, 0x103, old).rename(tmp_path / ("A" * 20)),
    ]
    elsewhere = cache_of(tmp_path / "elsewhere", 0x104, old)
    (tmp_path / f"{0x105:020x}").symlink_to(elsewhere)
    kernel_cache._prune(tmp_path)
    assert all((folder / "inner" / "index").exists() for folder in (*theirs, elsewhere))


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
