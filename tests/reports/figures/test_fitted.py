"""Fails where the picture of a fit leaves out events, or draws one where it can't be seen."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from ghostball.reports import style
from ghostball.reports.figures.fitted import draw_fit

LEFT = {"rolling": np.linspace(-9.0, 9.0, 30)[:, None], "hit": np.zeros((9, 8))}
FITTED = SimpleNamespace(
    families={
        name: [SimpleNamespace(speed=0.1 + k) for k in range(len(left))]
        for name, left in LEFT.items()
    },
    solutions={name: SimpleNamespace(residuals=left) for name, left in LEFT.items()},
)


@pytest.fixture
def figure(monkeypatch, tmp_path) -> Figure:
    drawn = []
    save = style.save_one
    monkeypatch.setattr(style, "save_one", lambda *given: (drawn.append(given[0]), save(*given)))
    draw_fit(FITTED, tmp_path / "left.png")
    with Image.open(tmp_path / "left.png") as image:
        assert image.width > 400
    return drawn[0]


def test_each_family_has_a_panel_with_all_its_numbers(figure):
    rolling, hits = figure.axes
    assert rolling.get_title(loc="left") == "Balls that roll: their deceleration (30)"
    assert "(9)" in hits.get_title(loc="left")
    assert len(rolling.lines[1].get_xdata()) == 30
    assert len(hits.lines[1].get_xdata()) == 72


def test_what_is_far_off_is_drawn_at_the_edge(figure):
    low, high = figure.axes[0].get_ylim()
    y = figure.axes[0].lines[1].get_ydata()
    assert low < min(y) < -5.0
    assert 5.0 < max(y) < high
