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


# Each is one thing, and tested as that.
AS_ONE = {
    "ghostball/pytest_plugin",
    "reference_adapters/box2d",
    "reference_adapters/box2d3",
    "reference_adapters/dart",
    "reference_adapters/mujoco",
    "reference_adapters/physx",
    "reference_adapters/pymunk",
    "reference_adapters/rapier",
    "reference_adapters/recipes",
    "validation/stress/families",
    "validation/truth/closed_forms",
}
# What they do is seen of the whole of their folder, whose tests ask for it.
IN_TESTS_OF_THE_FOLDER = {
    "ghostball/model/scene/obstacles.py",
    "ghostball/model/scene/part.py",
    "ghostball/model/scene/pockets.py",
    "ghostball/model/scene/toml_lines.py",
    "ghostball/model/trajectory/polynomial.py",
    "ghostball/model/trajectory/segment.py",
    "ghostball/model/trajectory/tangent_map.py",
    "reports/page/about.py",
    "reports/page/board.py",
    "reports/page/curves.py",
    "validation/grading/certified_air.py",
    "validation/grading/certified_events.py",
    "validation/grading/certified_flow.py",
    "validation/grading/slope.py",
    "validation/grading/tolerances.py",
    "validation/measured/fit/hits.py",
    "validation/parallel/group.py",
    "validation/suite/judge.py",
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


def has_tests(module: Path) -> bool:
    """Whether a file of its own has tests."""
    own = ROOT / "tests" / module.parent / f"test_{module.stem.strip('_')}.py"
    return own.exists() and "def test_" in own.read_text(encoding="utf-8")


@pytest.mark.checkout
def test_each_module_has_its_tests_where_they_are_looked_for():
    without = {
        module.as_posix()
        for module in modules()
        if module.parent.as_posix() not in AS_ONE and not has_tests(module)
    }
    assert without == DATA | IN_TESTS_OF_THE_FOLDER


@pytest.mark.checkout
@pytest.mark.parametrize("folder", sorted(AS_ONE))
def test_what_is_tested_as_one_has_the_tests_of_its_folder(folder):
    place = ROOT / "tests" / folder
    names = place / f"test_{place.name}.py", place.parent / f"test_{place.name}.py"
    assert any(name.exists() for name in names)
