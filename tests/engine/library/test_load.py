"""Tests of finding or making a library: no outdated one is used, and each is compiled once."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from copies import copy_packages

from ghostball.engine.library import build, cache, entry, load, processor, shipped, table
from ghostball.engine.library.entry import COMPILED, Entry, Needed, make_all
from ghostball.engine.library.table import kind_of
from ghostball.model import GhostballError
from ghostball.reference_adapters.stepping import cloth, slowing

pytestmark = pytest.mark.skipif(not COMPILED, reason="interpreted kernels have no libraries")

V, SLOWING = np.array([[1.0, 0.0]]), np.array([0.2])
STOP = slowing.stop.function
KINDS = [kind_of(one) for one in (V, SLOWING, SLOWING)]

# Two kernels in separate files, because the engine's kernels take far longer to compile.
CALLEE = """
from ghostball.engine.core.kernel import kernel

@kernel
def grown(x):
    return 2.0 * x
"""
CALLER = """
from ghostball.engine._callee import grown
from ghostball.engine.core.kernel import kernel

@kernel(entry=True)
def called(x) -> float:
    return grown(x) + 1.0
"""
CALL = "from ghostball.engine._caller import called; print(called(3.0))"


@pytest.fixture
def copy(tmp_path):
    """A copy of the engine with the two kernels, and without shipped libraries."""
    sources = copy_packages(tmp_path, "engine") / "engine"
    shutil.rmtree(sources / "library/shipped", ignore_errors=True)
    (sources / "_callee.py").write_text(CALLEE)
    (sources / "_caller.py").write_text(CALLER)
    return tmp_path


def in_copy(folder, cache_folder, program=CALL, **environment):
    """Return the command of a process that calls the kernel."""
    here = {"PYTHONPATH": str(folder), "GHOSTBALL_CACHE_DIR": str(cache_folder)}
    return {
        "args": [sys.executable, "-c", program],
        "env": {**os.environ, **here, **environment},
        "cwd": folder,
        "stdout": subprocess.PIPE,
        "stderr": subprocess.PIPE,
        "text": True,
    }


def run_copy(folder, cache_folder, program=CALL, **environment):
    done = subprocess.run(**in_copy(folder, cache_folder, program, **environment), check=False)
    assert done.returncode == 0, done.stderr
    return float(done.stdout), done.stderr


@pytest.mark.slow
def test_an_edited_callee_in_another_file_is_seen_and_a_comment_is_not(copy):
    found, messages = run_copy(copy, copy / "cache")
    assert found == 7.0
    assert "compiling the engine's kernels (called), once" in messages
    assert run_copy(copy, copy / "cache") == (7.0, "")
    callee = copy / "ghostball/engine/_callee.py"
    callee.write_text(CALLEE.replace("2.0 * x", "2.0 * x  # twice"))
    assert run_copy(copy, copy / "cache") == (7.0, "")
    callee.write_text(CALLEE.replace("2.0 * x", "3.0 * x"))
    assert run_copy(copy, copy / "cache")[0] == 10.0


@pytest.mark.slow
def test_sources_that_are_changed_while_a_program_runs_are_not_compiled(copy):
    """Otherwise the new code would be stored under the name of the old sources."""
    process = in_copy(copy, copy / "cache")
    edit = "import pathlib; file = pathlib.Path('ghostball/engine/_callee.py');"
    # The new text has another length: Python detects outdated bytecode by length and whole seconds.
    edit += "file.write_text(file.read_text().replace('2.0', '3.000'));"
    process["args"][2] = CALL.replace(";", f"; {edit}", 1)
    done = subprocess.run(**process, check=False)
    assert done.returncode == 1
    assert "sources of the kernel changed after the program started" in done.stderr
    assert not [*(copy / "cache" / "libraries").glob("*.so")]
    assert run_copy(copy, copy / "cache")[0] == 10.0


@pytest.mark.slow
def test_only_one_of_two_processes_compiles_and_the_other_waits(copy):
    both = [subprocess.Popen(**in_copy(copy, copy / "cache")) for _ in range(2)]
    said = [process.communicate() for process in both]
    assert [out for out, _ in said] == ["7.0\n", "7.0\n"]
    assert sum("compiling" in messages for _, messages in said) == 1


def test_an_unwritable_cache_is_reported_and_does_not_stop_the_run(copy):
    blocked = copy / "file"
    blocked.write_text("")
    found, messages = run_copy(copy, blocked / "cache")
    assert found == 7.0
    assert "GHOSTBALL_CACHE_DIR" in messages
    assert "Traceback" not in messages


@pytest.mark.slow
@pytest.mark.parametrize(
    ("linker", "reason"),
    [
        ("", "no C compiler found (tried cc, clang, gcc). Set CC to a compiler"),
        ("nowhere/cc", "`nowhere/cc` can't be run: No such file or directory"),
        ("/bin/sh -c 'echo no >&2; echo room >&2; exit 1'", "failed: no room"),
    ],
)
def test_if_linking_fails_a_message_says_so_and_the_object_file_is_loaded(copy, linker, reason):
    empty = copy / "no programs"
    empty.mkdir()
    found, messages = run_copy(copy, copy / "cache", PATH=str(empty), CC=linker)
    assert found == 7.0
    compiling, unlinked = messages.splitlines()
    assert "compiling" in compiling
    assert unlinked.startswith("no library could be linked")
    assert unlinked.endswith(reason)
    assert run_copy(copy, copy / "cache", PATH=str(empty), CC=linker) == (7.0, "")
    (made,) = (copy / "cache" / "libraries").glob("called-*.o")
    assert not made.with_suffix(".so").exists()


WITHOUT_NUMBA = """
import importlib.util as util
found = util.find_spec
util.find_spec = lambda name, *more: None if name == "numba" else found(name, *more)
"""
WITHOUT_WIDE_VECTORS = """
from ghostball.engine.library import processor
processor.target = lambda: processor.GENERIC[processor.machine()]
"""
SHIP = """
import json
from ghostball.engine._caller import called
from ghostball.engine.library import load, shipped
shipped.FOLDER.mkdir()
load.build([load.Order(called.function, ["float"], shipped.FOLDER / "called.so")])
found = shipped.manifest({shipped.key_of(called.function, ["float"]): "called.so"})
(shipped.FOLDER / shipped.MANIFEST).write_text(json.dumps(found))
print(0)
"""


@pytest.fixture
def came(copy):
    """A copy with a shipped library for any processor, and its folder."""
    run_copy(copy, copy / "cache", WITHOUT_WIDE_VECTORS + SHIP)
    return copy, copy / "ghostball/engine/library/shipped"


def spoil_manifest(**changes):
    """Return a change that makes the library unsuitable; `test_shipped.py` tests all reasons."""

    def spoil(folder):
        manifest = folder / shipped.MANIFEST
        manifest.write_text(json.dumps({**json.loads(manifest.read_text()), **changes}))

    return spoil


def spoil_library(folder):
    (folder / "called.so").write_text("no library")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (spoil_manifest(sources=""), "the sources have changed"),
        (spoil_manifest(table=table.VERSION + 1), "they have another calling interface"),
        (spoil_manifest(system="plan9-x86_64"), "they are for another system"),
        (spoil_manifest(target=processor.WIDE), "they are for processors with "),
        (spoil_library, "called.so: "),
    ],
    ids=["sources", "version", "system", "processor", "library"],
)
def test_an_unsuitable_shipped_library_is_replaced_or_a_message_names_the_compiler(
    came, spoil, reason
):
    copy, folder = came
    call = WITHOUT_WIDE_VECTORS + CALL
    assert run_copy(copy, copy / "none", WITHOUT_NUMBA + call) == (7.0, "")
    assert not (copy / "none").exists()
    spoil(folder)

    process = in_copy(copy, copy / "cache", WITHOUT_NUMBA + call)
    done = subprocess.run(**process, check=False)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].endswith(
        "NoCompilerError: kernels must be compiled, but numba, the compiler, isn't "
        "installed. Run `pip install '.[compiler]'` in a clone of Ghostball"
    )
    assert "compiling" not in done.stderr

    found, messages = run_copy(copy, copy / "cache", call)
    assert found == 7.0
    aside, compiling = messages.splitlines()
    assert compiling.startswith("compiling the engine's kernels (called), once")
    assert aside.startswith("the shipped kernels are not used: ")
    assert reason in aside


def test_without_a_compiler_a_message_names_what_to_install(copy):
    process = in_copy(copy, copy / "cache", WITHOUT_NUMBA + CALL)
    done = subprocess.run(**process, check=False)
    assert done.returncode == 1
    assert "NoCompilerError" in done.stderr
    assert "pip install '.[compiler]'" in done.stderr


def test_a_library_that_the_system_cannot_load_is_reported(monkeypatch, tmp_path):
    path = tmp_path / "stop.so"
    path.write_text("no library")
    monkeypatch.setattr(load, "find", lambda *_: path)
    with pytest.raises(GhostballError, match=r"stop\.so: .*set GHOSTBALL_CACHE_DIR"):
        Entry(STOP)(V, SLOWING, np.empty(1))


def test_a_failed_compilation_is_reported_with_the_reason(copy):
    callee = copy / "ghostball/engine/_callee.py"
    callee.write_text(CALLEE.replace("2.0 * x", "x.nothing"))
    done = subprocess.run(**in_copy(copy, copy / "cache"), check=False)
    assert "kernels ['ghostball.engine._caller:called'] could not be compiled" in done.stderr
    assert "Unknown attribute 'nothing'" in done.stderr


@pytest.mark.slow
def test_with_bounds_checks_an_index_outside_an_array_is_an_error(copy):
    callee = copy / "ghostball/engine/_callee.py"
    callee.write_text(CALLEE.replace("2.0 * x", "x[7]"))
    process = in_copy(copy, copy / "cache", NUMBA_BOUNDSCHECK="1")
    process["args"][2] = CALL.replace("3.0", "__import__('numpy').zeros(3)")
    done = subprocess.run(**process, check=False)
    assert done.returncode == 1
    assert "IndexError: the kernel `called` used an index outside an array" in done.stderr


@pytest.mark.slow
def test_missing_libraries_are_made_together_and_existing_ones_kept(monkeypatch, tmp_path):
    monkeypatch.setattr(cache, "directory", lambda: tmp_path)
    monkeypatch.setattr(shipped, "files", dict)
    monkeypatch.setattr(entry, "KERNELS_PER_PROCESS", 2)
    needed, names = cloth.needed()[1:], []
    make_all(needed, 2, names.append)
    assert sorted(names) == sorted(one.name for one in needed)
    assert all(one.is_made for one in needed)
    monkeypatch.setattr(load, "build", lambda *_: pytest.fail("they were there"))
    make_all(needed, 2)


def test_a_kernel_that_cannot_be_compiled_is_named_among_many(monkeypatch, tmp_path):
    monkeypatch.setattr(cache, "directory", lambda: tmp_path)
    wrong = Needed(slowing.stop, (V, SLOWING, 1.0), "durations")
    with pytest.raises(GhostballError, match=r"slowing:stop'\] could not be compiled"):
        make_all([wrong], 1)


@pytest.fixture
def anew(monkeypatch, tmp_path):
    """An entry without a loaded library, and an empty cache."""
    monkeypatch.setattr(cache, "directory", lambda: tmp_path)
    monkeypatch.setattr(shipped, "files", dict)
    return Entry(STOP)


def durations(kernel):
    times = np.empty(1)
    kernel(V, SLOWING, times)
    return times[0]


def test_shipped_libraries_come_before_those_of_the_cache(anew, monkeypatch, tmp_path):
    """Nothing is compiled, and numba isn't needed."""
    path = load.find(STOP, KINDS) or tmp_path / "none"
    load.build([load.Order(STOP, KINDS, tmp_path / "shipped.so")])
    files = {shipped.key_of(STOP, KINDS): tmp_path / "shipped.so"}
    monkeypatch.setattr(shipped, "files", lambda: files)
    monkeypatch.setattr(load, "find_spec", lambda name: None)
    assert load.find(STOP, KINDS) == tmp_path / "shipped.so" != path
    assert durations(anew) == 5.0
    monkeypatch.setattr(shipped, "files", dict)
    with pytest.raises(load.NoCompilerError):
        durations(Entry(STOP))


def test_another_processor_has_another_library(monkeypatch):
    names = {load.name_of(STOP, KINDS)}
    monkeypatch.setattr(processor, "target", lambda: "x86-64")
    names.add(load.name_of(STOP, KINDS))
    monkeypatch.setattr(processor, "system", lambda: "plan9-x86_64")
    names.add(load.name_of(STOP, KINDS))
    monkeypatch.setattr(load, "_compiler", lambda: "another")
    names.add(load.name_of(STOP, KINDS))
    names.add(load.name_of(STOP, KINDS[:2]))
    assert len(names) == 5


@pytest.mark.parametrize("flag", shipped.FLAGS)
def test_settings_of_numba_have_another_library(monkeypatch, flag):
    monkeypatch.delenv(f"NUMBA_{flag}", raising=False)
    name = load.name_of(STOP, KINDS)
    monkeypatch.setenv(f"NUMBA_{flag}", "17")
    assert load.name_of(STOP, KINDS) != name


@pytest.mark.slow
def test_code_for_any_processor_has_the_same_bits(anew, monkeypatch, tmp_path):
    expected = durations(slowing.stop)
    monkeypatch.setattr(processor, "target", lambda: processor.GENERIC[processor.machine()])
    assert durations(anew) == expected


def test_the_digest_identifies_the_compiler(monkeypatch):
    assert load._compiler.__wrapped__() == load._compiler()
    monkeypatch.setattr("importlib.metadata.version", lambda name: "0.1")
    assert load._compiler.__wrapped__() != load._compiler()
    assert Path(build.__file__).parent == Path(load.__file__).parent


def test_warnings_of_the_compiler_are_logged(monkeypatch, caplog, tmp_path):
    warns = "import sys; sys.stdin.read(); print('numba differs', file=sys.stderr)"
    monkeypatch.setattr(load, "_ORDERED", warns)
    load._say_of_compiler.cache_clear()
    load.build([load.Order(STOP, KINDS, tmp_path / "stop.so")])
    assert caplog.messages == ["while kernels were compiled: numba differs"]
