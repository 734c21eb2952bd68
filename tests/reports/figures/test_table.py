"""A table is drawn to scale, and no ball that an engine lost shrinks it to a dot."""

import numpy as np
import pytest

from ghostball.model import Ball, Scene, Table
from ghostball.reports import style
from ghostball.reports.figures._table import aspect_of, draw_discs, draw_table, view_of

TABLE = Table(length=2.0, width=1.0, cushions=("left", "right", "bottom"))
CUE = Ball(id="cue", position=(0.5, 0.5), velocity=(1.0, 0.0))
SCENE = Scene(name="one", table=TABLE, balls=[CUE])


def holds(view, x, y):
    left, right, bottom, top = view
    return left <= x <= right and bottom <= y <= top


def test_the_whole_table_is_seen_and_what_is_lost_far_away_is_not():
    alone = view_of(SCENE)
    assert holds(alone, 0.0, 0.0)
    assert holds(alone, 2.0, 1.0)
    lost = np.array([[[1000.0, 0.5, 0.0]], [[np.nan, 0.5, 0.0]]])
    view = view_of(SCENE, lost)
    assert not holds(view, 1000.0, 0.5)
    assert view[1] <= 1.25 * TABLE.length
    assert holds(view_of(SCENE, lost, needed=lost[0]), 1000.0, 0.5)


def test_a_straight_shot_without_a_table_is_no_line():
    scene = Scene(name="far", balls=[CUE])
    view = view_of(scene, np.array([[[9.0, 0.5, 0.0]]]))
    assert aspect_of(view) == pytest.approx(0.3, abs=0.05)


def test_cushions_are_bars_a_side_without_one_is_dotted_and_discs_have_their_radius():
    with style.drawing():
        axes = style.new_figure(4.0, 3.0).subplots()
        view = view_of(SCENE)
        draw_table(axes, SCENE, view, ticks=False)
        discs = draw_discs(axes, SCENE.positions, SCENE.radii)
    assert len(axes.patches) == 1 + 3  # cloth and cushions
    assert [line.get_linestyle() for line in axes.lines] == [":"]
    assert axes.get_aspect() == 1.0
    assert (*axes.get_xlim(), *axes.get_ylim()) == view
    assert discs.get_widths() == pytest.approx(2.0 * SCENE.radii)
