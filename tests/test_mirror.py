"""Whoever looks for the tests of `x/y.py` finds them at `tests/x/test_y.py`.

A folder whose modules are one thing, such as the adapter of an engine, may be tested as that:
`tests/x/test_x.py` or `tests/test_x.py` then.
"""

from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FOLDERS = ("ghostball", "engine", "reference_adapters", "validation", "reports", "benchmarks")
# Names of constants, fields and types: there is nothing to call.
DATA = {
    "engine/capabilities.py",
    "engine/core/tolerances.py",
    "engine/impacts/laws/interface.py",
    "engine/sensitivity/state.py",
    "ghostball/model/arrays.py",
}


def modules() -> list[Path]:
    """All modules, each once: four of the folders are linked into `ghostball`."""
    found = []
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*.py")):
            inside = path.relative_to(ROOT)
            linked = inside.parts[0] == "ghostball" and inside.parts[1] in FOLDERS
            if path.name != "__init__.py" and not linked:
                found.append(inside)
    return found


def places_of(module: Path) -> list[Path]:
    """Where the tests of a module may stand."""
    folder, package = ROOT / "tests" / module.parent, module.parent.name
    return [
        folder / f"test_{module.stem.strip('_')}.py",
        folder / f"test_{package}.py",
        folder.parent / f"test_{package}.py",
    ]


@pytest.mark.checkout
def test_each_module_has_its_tests_where_they_are_looked_for():
    without = {
        module.as_posix()
        for module in modules()
        if not any(place.exists() for place in places_of(module))
    }
    assert without == DATA
