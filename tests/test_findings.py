"""What is sent to other projects runs without this one, and is of the versions that it names."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FINDINGS = ROOT / "docs/findings"
PROGRAMS = sorted(FINDINGS.glob("*.py"))
PAGES = sorted(set(FINDINGS.glob("*.md")) - {FINDINGS / "README.md"})

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


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_a_page_is_listed_with_the_version_that_it_is_of_and_shows_how_to_get_it(page):
    heading, _, text = page.read_text(encoding="utf-8").partition("\n")
    version = re.search(r"(?:pip install [\w-]+==|npm install [\w-]+@)([\d.]+)", text)[1]
    assert version in heading
    table = (FINDINGS / "README.md").read_text(encoding="utf-8").splitlines()
    (row,) = (line for line in table if f"({page.name})" in line)
    assert row.startswith(f"| {heading.removeprefix('# ').partition(':')[0]} |")
    assert f"findings/{page.name}" in (ROOT / "mkdocs.yml").read_text(encoding="utf-8")


def test_each_program_has_a_page_that_is_listed_and_shows_how_to_run_it():
    table = (FINDINGS / "README.md").read_text(encoding="utf-8")
    assert len(PROGRAMS) >= 3
    for program in PROGRAMS:
        page = program.with_name(program.stem.replace("_", "-") + ".md")
        assert page in PAGES
        assert f"    python {program.name}\n" in page.read_text(encoding="utf-8")
        assert f"({program.name})" in table
