"""Whoever is cited with a year stands on the page of references."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs/references.md"
FOLDERS = (
    "engine",
    "ghostball",
    "reference_adapters",
    "validation",
    "reports",
    "benchmarks",
    "docs",
)
CITED = re.compile(
    r"\b([A-Z][a-zé]+)(?:(?:,? (?:and|&) [A-Z][a-zé]+)| et al\.)?,?\s\(?((?:18|19|20)\d\d)\b"
)
NO_AUTHORS = {"Somebody", "November", "December", "October", "September", "August", "July", "June"}
NO_AUTHORS |= {"May", "April", "March", "February", "January", "Version", "Python"}

pytestmark = pytest.mark.checkout


def cited() -> dict[tuple[str, str], str]:
    """Return first author and year of each citation, with a file that has it."""
    found = {}
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in (".py", ".md", ".toml") and path != PAGE and path.is_file():
                text = re.sub(r"\n[ #]*", " ", path.read_text(encoding="utf-8"))
                for author, year in CITED.findall(text):
                    if author not in NO_AUTHORS:
                        found.setdefault((author, year), str(path.relative_to(ROOT)))
    return found


def test_every_citation_has_its_source():
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    found = cited()
    assert len(found) > 30
    missing = {
        one: path
        for one, path in found.items()
        if not any(one[0] in line and one[1] in line for line in lines)
    }
    assert not missing


def test_the_draft_of_the_paper_cites_what_its_bibliography_has():
    text = (ROOT / "paper/paper.md").read_text(encoding="utf-8")
    bibliography = (ROOT / "paper/paper.bib").read_text(encoding="utf-8")
    keys = re.findall(r"^@\w+\{(\w+),", bibliography, re.MULTILINE)
    assert sorted(set(re.findall(r"@(\w+)", text.partition("# Summary")[2]))) == sorted(keys)
    assert len(text.split()) < 1200
    measured = re.search(
        r"Of (\d+) events proved in (\d+) random shots",
        " ".join((ROOT / "docs/measured.md").read_text(encoding="utf-8").split()),
    )
    said = [f"{int(number):,}".replace(",", " ") for number in measured.groups()]
    assert "Of {} events proved in {} random shots".format(*said) in " ".join(text.split())


def test_a_source_is_there_once_and_in_order():
    for table in PAGE.read_text(encoding="utf-8").split("\n## ")[1:]:
        rows = re.findall(r"^\| (\w.*?)[,:]? ", table, re.MULTILINE)[1:]
        names = [row.casefold() for row in rows if row != "erdo100"]
        assert names == sorted(names)
    links = re.findall(r"\[doi:(\S+?)\]\((\S+?)\) ", PAGE.read_text(encoding="utf-8"))
    assert len(links) > 25
    assert len(set(links)) == len(links)
    assert all(link == f"https://doi.org/{doi}" for doi, link in links)
