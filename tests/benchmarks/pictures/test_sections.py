"""The paper's wishes as pictures: each is drawn, and says what its rule of turning is worth."""

import numpy as np
import pytest

from benchmarks.pictures.sections import RULES, SECTION_FIGURES, turned_off
from benchmarks.pictures.shots import our_shot
from ghostball.engine import simulate
from ghostball.reports import style
from ghostball.reports.figures.heights import flying, part_in_flight
from ghostball.reports.figures.paths import is_collinear
from ghostball.reports.figures.sheet import draw_sheet
from ghostball.reports.figures.single import draw_single
from ghostball.reports.shots import Shot, load_shot
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.suite.suite import run_suite

SCENES = (
    *("wall-bounce", "masse", "sliding-swerve", "air-rolls", "restitution-bounce"),
    "flight-jump",
)


@pytest.fixture(scope="module")
def wishes(tmp_path_factory) -> Results:
    """Every scene that the pictures need, on our engine and on the paper's."""
    folder = tmp_path_factory.mktemp("wishes")
    run_suite([find_scene(name) for name in SCENES], ["ghostball", "paper-discrete"], folder)
    return Results.open(folder)


@pytest.fixture(autouse=True)
def _unlaid(monkeypatch: pytest.MonkeyPatch) -> None:
    # Laying out takes seconds, and is tested with figures.
    monkeypatch.setattr(style, "lay_out", lambda _: None)


@pytest.mark.parametrize("name", SECTION_FIGURES)
def test_each_wish_has_a_picture_that_says_what_every_engine_makes_of_it(wishes, name):
    figure = SECTION_FIGURES[name](wishes)
    said = " ".join(text.get_text() for axes in figure.axes for text in axes.texts)
    assert "ghostball" in said
    if name != "paper-section-6-1":
        assert "not representable: no " in said


def test_the_papers_rule_turns_backwards_and_about_the_other_axis_falls_behind(wishes):
    printed, mended = RULES
    off = turned_off(*our_shot(wishes, "wall-bounce"))
    assert off[printed][1].max() > 3.0
    # v dt / 2 R of the way, for each way that ends: 0.3 rad and less.
    assert 1e-3 < off[mended][1].max() < 1.0
    # A ball that slides turns otherwise than it rolls: no axis in the plane mends that.
    assert turned_off(*our_shot(wishes, "masse"))[mended][1].max() > 2.0


def test_where_a_ball_flies_its_height_is_drawn(wishes):
    jump, roll = (load_shot(wishes, name) for name in ("flight-jump", "wall-bounce"))
    assert flying(jump).tolist() == [True, False, False]
    assert not flying(roll).any()
    landed = simulate(find_scene("flight-jump"), record="trajectory")
    assert part_in_flight(jump) == pytest.approx(0.7, abs=0.05)
    high = landed.sample(np.linspace(part_in_flight(jump), landed.rest_time, 50)).positions
    assert np.ptp(high[:, :, 2]) < 1e-4  # a bounce that nobody sees
    for draw, narrow in ((draw_sheet, False), (draw_single, True)):
        counts = []
        for shot in (jump, roll):
            one = Shot(shot.scene, (shot.ours,)) if narrow else shot
            figure = draw(one)
            counts.append(len(figure.axes) - is_collinear(one))
        assert counts[0] == counts[1] + 1
