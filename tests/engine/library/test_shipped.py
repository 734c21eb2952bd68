"""Tests of shipped libraries: which are used, and why others are set aside."""

import ast
import json
from pathlib import Path
from types import ModuleType

import pytest

from ghostball import engine
from ghostball.engine.library import processor, shipped, table
from ghostball.reference_adapters.stepping import slowing

STOP = slowing.stop.function
KINDS = [["array", "f8", 2], ["array", "f8", 1], ["array", "f8", 1]]
NAME = shipped.key_of(STOP, KINDS)


@pytest.fixture
def come(monkeypatch, tmp_path):
    """Add shipped libraries to the package, with a manifest that has these changes."""
    monkeypatch.setattr(shipped, "FOLDER", tmp_path)
    monkeypatch.setattr(shipped, "files", shipped.files.__wrapped__)
    for name in shipped.FLAGS:
        monkeypatch.delenv(f"NUMBA_{name}", raising=False)

    def with_changes(**changes):
        found = {**shipped.manifest({NAME: "stop.so"}), **changes}
        (tmp_path / shipped.MANIFEST).write_text(json.dumps(found))
        return shipped.files()

    return with_changes


def test_suitable_libraries_are_found_by_kernel_and_arguments(come, tmp_path, caplog):
    assert come() == {NAME: tmp_path / "stop.so"}
    assert caplog.text == ""
    assert shipped.key_of(STOP, KINDS[:2]) != NAME
    assert shipped.key_of(slowing.slow.function, KINDS) != NAME


def test_without_shipped_libraries_there_is_no_message(come, caplog):
    assert shipped.files() == {}
    assert caplog.text == ""


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"table": table.VERSION + 1}, "another calling interface"),
        ({"system": "plan9-x86_64"}, "for another system"),
        ({"sources": "0" * 64}, "the sources have changed"),
    ],
)
def test_unsuitable_libraries_are_not_used_with_a_message(come, changes, reason, caplog):
    assert come(**changes) == {}
    (record,) = caplog.records
    assert "shipped kernels are not used: " in record.message
    assert reason in record.message
    assert "\n" not in record.message


def test_libraries_for_a_newer_processor_are_not_used(come, monkeypatch, caplog):
    monkeypatch.setattr(processor, "target", lambda: "x86-64")
    assert come(target=processor.WIDE) == {}
    assert f"processors with {', '.join(sorted(processor.NEEDED))}" in caplog.text
    assert come(target="x86-64") != {}


@pytest.mark.parametrize("flag", shipped.FLAGS)
def test_settings_of_numba_ask_for_others(come, monkeypatch, flag, caplog):
    monkeypatch.setenv(f"NUMBA_{flag}", "1")
    assert come() == {}
    assert f"NUMBA_{flag} requires other kernels" in caplog.text


def test_sources_are_those_of_the_engine_of_adapters_and_of_the_model(monkeypatch, tmp_path):
    before = shipped.sources()
    assert shipped.sources() == before
    file = tmp_path / "events.py"
    file.write_text("BALL_BALL = 0")
    module = ModuleType("events")
    module.__file__ = str(file)
    monkeypatch.setattr(shipped, "MODEL_MODULES", (module,))
    changed = shipped.sources()
    assert changed != before
    file.write_text("BALL_BALL = 7")
    assert shipped.sources() not in (before, changed)
    names = dict(shipped._files())
    assert "event_loop/play.py" in names
    assert names["stepping/slowing.py"] == Path(slowing.__file__).resolve()


def test_kernels_take_nothing_else_from_the_model():
    """If a module isn't in the hash, an edit of its constants wouldn't change the machine code."""
    allowed = {module.__name__ for module in shipped.MODEL_MODULES}
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
            if beside is not None and beside not in read and LIBRARY not in beside.parents:
                unread.append(beside)


PACKAGE = Path(engine.__file__).parent
LIBRARY = PACKAGE / "library"


def imported_by(path):
    """Return the names that a module imports from the package, each with its full name."""
    loaded = ast.parse(path.read_text()).body
    return {
        alias.asname or alias.name: f"{node.module}.{alias.name}"
        for node in loaded
        if isinstance(node, ast.ImportFrom) and node.module.startswith("ghostball.")
        for alias in node.names
    }


def file_of(name):
    """Return the file of the engine that defines a name, or None."""
    parts = name.split(".")
    if parts[:2] != ["ghostball", "engine"]:
        return None
    for end in (len(parts), len(parts) - 1):
        place = PACKAGE.joinpath(*parts[2:end])
        for file in (place.with_suffix(".py"), place / "__init__.py"):
            if file.is_file():
                return file
    raise AssertionError(name)
