"""Each engine has a page in the documentation, and the board there leads to it, in colours."""

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


def test_a_cell_leads_to_its_engine_and_has_the_colour_of_its_class():
    from benchmarks.pictures.gallery import committed_board
    from docs.engine_pages import cell_link, coloured

    board = committed_board()
    column = next(one for one in board.columns if one.id == "cut")
    link = cell_link(board, "pymunk:config=naive", column)
    assert "](engines/pymunk.md#cut" in link
    title = link.partition('"')[2].rpartition('"')[0]
    html = coloured(f'<tr><td><a href="x" title="{title}">4 mm</a></td></tr>')
    assert 'class="cell" style="background:#' in html
    assert 'data-size="' in html
    assert '<a href="../replays/cut.html#pymunk:config=naive" title=' in html
    gas = title.replace(", cut: ", ", gas: ")
    assert '<a href="x" title=' in coloured(f'<td><a href="x" title="{gas}">kept</a></td>')
    assert coloured("<td>other</td>") == "<td>other</td>"
