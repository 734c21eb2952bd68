"""What the documentation shows has numpydoc sections; all else says it in sentences."""

import ast
import re
from pathlib import Path
from pkgutil import resolve_name

import pytest

ROOT = Path(__file__).parent.parent
PACKAGES = {
    "ghostball/model": "ghostball.model",
    "engine": "ghostball.engine",
    "reference_adapters": "ghostball.reference_adapters",
    "validation": "ghostball.validation",
    "reports": "ghostball.reports",
    "ghostball/cli": "ghostball.cli",
    "ghostball/pytest_plugin": "ghostball.pytest_plugin",
    "benchmarks": "benchmarks",
}
SECTION = re.compile(r"^ *(Parameters|Returns|Yields|Raises|Attributes|Notes)\n *-{4,}$", re.M)
SHOWN = re.findall(r"^::: (\S+)", (ROOT / "docs/api.md").read_text(encoding="utf-8"), re.M)


def shown():
    """Return what is shown, as module and name of where it is defined."""
    for name in SHOWN:
        found = resolve_name(name)
        yield f"{found.__module__}.{found.__qualname__}"


def with_sections(node, name):
    """Yield the names of what has sections, but for what is shown, and its members."""
    for child in ast.iter_child_nodes(node):
        inner = name
        if isinstance(child, ast.FunctionDef | ast.ClassDef):
            inner = f"{name}.{child.name}"
            if inner in SHOWN_AT:
                continue
            if SECTION.search(ast.get_docstring(child) or ""):
                yield inner
        yield from with_sections(child, inner)


SHOWN_AT = frozenset(shown())


@pytest.mark.checkout
@pytest.mark.parametrize("folder", PACKAGES)
def test_only_what_the_documentation_shows_has_sections(folder):
    found = []
    for path in sorted((ROOT / folder).rglob("*.py")):
        parts = path.relative_to(ROOT / folder).with_suffix("").parts
        module = ".".join([PACKAGES[folder], *(part for part in parts if part != "__init__")])
        found += with_sections(ast.parse(path.read_text(encoding="utf-8")), module)
    assert found == []


def test_sections_are_found():
    tree = ast.parse('def f(x):\n    """Do it.\n\n    Returns\n    -------\n    int\n    """\n')
    assert [*with_sections(tree, "m")] == ["m.f"]
