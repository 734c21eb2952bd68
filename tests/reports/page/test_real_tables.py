"""The page shows the measured comparisons with real tables, and unsupported families."""

from __future__ import annotations

import re

import pytest
from table_agreements import keep_likenesses

from ghostball.reports.page.real_tables import real_tables_html
from ghostball.validation.measured.table_agreement import (
    ComparedFigure,
    FigureFamily,
    TableAgreement,
)
from ghostball.validation.results.store import Results

EVIL = "</script><img src=x onerror=alert(1)>"


def family(**fields) -> FigureFamily:
    return FigureFamily(
        name="cushion",
        short="rebound",
        title="Rebounds",
        quantity="ratio",
        unit="1",
        against="speed [m/s]",
        citation="Somebody 2024",
        **fields,
    )


FIGURES = (
    ComparedFigure(at=0.5, value=0.55, error=0.01, played=0.56),
    ComparedFigure(at=1.0, value=0.55, error=0.01, played=0.56),
    ComparedFigure(at=1.5, value=0.54, error=0.01, played=0.57),
)
SHOWN = FigureFamily(
    name="hit-speeds",
    short="hits",
    title="Hits",
    quantity="speed",
    unit="1",
    against="cut [degrees]",
    citation="Somebody else 2023",
    conditions="no error is known",
    grades=False,
)
HITS = tuple(
    ComparedFigure(at=at, value=value, error=None, played=value + 0.025, what=what)
    for at in (10.0, 20.0, 30.0)
    for what, value in (("cue ball", 0.4), ("object ball", 0.5))
)
FOUND = [
    TableAgreement(
        label="ghostball",
        families=(
            family(figures=FIGURES, settings={"cushion": "x"}),
            SHOWN.model_copy(update={"figures": HITS}),
        ),
    ),
    TableAgreement(label="other", families=(family(lacks=EVIL), SHOWN.lacking("no balls"))),
]


def html_of(found, folder) -> str:
    keep_likenesses(folder, found)
    return str(real_tables_html(Results(folder, [], {})))


@pytest.fixture
def html(tmp_path) -> str:
    return html_of(FOUND, tmp_path)


def test_a_folder_without_them_has_no_section(tmp_path):
    assert real_tables_html(Results(tmp_path, [], {})) == ""


def test_an_engine_is_shown_by_how_far_it_is_off(html):
    text = " ".join(re.sub(r"<[^>]*>", " ", html).split())
    assert "engine rebound ghostball 1.9 (3.0) other –" in text
    assert "engine hits ghostball 2.5 % other –" in text
    assert "Somebody 2024" in text
    assert "rebound: cushion = x" in text


def test_measured_points_have_bars_and_engines_curves(html):
    assert html.count("two standard errors</title>") == len(FIGURES)
    assert html.count("<title>ghostball</title>") == 3


def test_each_thing_that_was_measured_has_its_sign(html):
    assert html.count("■<title>object ball: 0.5</title>") == 3
    assert html.count("●<title>cue ball: 0.4</title>") == 3
    assert "Measured: ● cue ball, ■ object ball; Somebody else 2023." in html


def test_what_is_nearly_proportional_is_drawn_over_it(tmp_path):
    banks = family(figures=FIGURES).model_copy(update={"name": "banks-pool"})
    found = TableAgreement(label="ghostball", families=(banks,))
    keep_likenesses(tmp_path, [found])
    html = str(real_tables_html(Results(tmp_path, [], {})))
    assert [f"<title>{x}</title>" in html for x in ("1.1", "0.55", "0.36")] == [True] * 3


def test_what_an_engine_lacks_is_said_and_harmless(html):
    assert "doesn't support: rebound, because" in html
    assert "hits, because no balls" in html
    assert "<img" not in html


def test_a_first_engine_that_lacks_all_hides_no_curve_of_the_others(tmp_path):
    assert "<title>ghostball</title>" in html_of(FOUND[::-1], tmp_path)


def test_figures_with_a_description_each_are_points_of_one_chart(tmp_path):
    figures = tuple(
        ComparedFigure(at=float(at), value=0.8, error=0.04, played=0.7, what=f"break {at}")
        for at in range(1, 6)
    )
    breaks = SHOWN.model_copy(update={"figures": figures})
    keep_likenesses(tmp_path, [TableAgreement(label="ghostball", families=(breaks,))])
    page = str(real_tables_html(Results(tmp_path, [], {})))
    for at in range(1, 6):
        assert f"break {at}: 0.8" in page
