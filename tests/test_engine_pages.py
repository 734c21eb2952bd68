"""Each engine has a page in the documentation."""

from pathlib import Path

import pytest

from ghostball.reference_adapters import engine_names

pytestmark = pytest.mark.checkout

ROOT = Path(__file__).resolve().parents[1]
SHIPPED = [name for name in engine_names() if name in (ROOT / "pyproject.toml").read_text("utf-8")]


@pytest.mark.parametrize("name", SHIPPED)
def test_an_engine_has_a_page_that_the_site_lists(name):
    text = (ROOT / f"docs/engines/{name}.md").read_text("utf-8")
    assert f'engine_pages.page("{name}")' in text
    assert f"engines/{name}.md" in (ROOT / "mkdocs.yml").read_text("utf-8")
