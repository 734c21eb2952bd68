"""What is sent to other projects runs without this one, and is of the versions that it names."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FINDINGS = ROOT / "docs/findings"
PROGRAMS = sorted(FINDINGS.glob("*.py"))

pytestmark = pytest.mark.checkout


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: path.stem)
def test_a_program_needs_its_engine_alone(program):
    tree = ast.parse(program.read_text(encoding="utf-8"))
    imported = {
        name.partition(".")[0]
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for name in (
            [node.module] if isinstance(node, ast.ImportFrom) else [a.name for a in node.names]
        )
    }
    engine = program.stem.partition("_")[0]
    assert imported - {"importlib", "warnings"} == {engine}


def test_each_has_a_page_that_is_listed_and_shows_how_to_run_it():
    table = (FINDINGS / "README.md").read_text(encoding="utf-8")
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    assert len(PROGRAMS) >= 3
    for program in PROGRAMS:
        page = program.with_name(program.stem.replace("_", "-") + ".md")
        text = page.read_text(encoding="utf-8")
        assert f"    python {program.name}\n" in text
        version = re.search(r"pip install [\w-]+==([\d.]+)", text)[1]
        assert version in text.splitlines()[0]
        assert f"({page.name})" in table
        assert f"({program.name})" in table
        assert f"findings/{page.name}" in navigation
