"""Pictures of the paper's section 6, future work, and the errors of its rule for rotation."""

import pytest

from benchmarks.pictures.sections import RULES, SECTION_FIGURES, turned_off
from benchmarks.pictures.shots import our_shot
from ghostball.reports import style
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.suite.suite import run_suite

SCENES = (
    *("wall-bounce", "masse", "sliding-swerve", "air-rolls", "restitution-bounce"),
    "flight-jump",
)


@pytest.fixture(scope="module")
def wishes(tmp_path_factory) -> Results:
    """Results of every scene of the pictures, on Ghostball's engine and on the paper's engines."""
    folder = tmp_path_factory.mktemp("wishes")
    run_suite([find_scene(name) for name in SCENES], ["ghostball", "paper-discrete"], folder)
    return Results.open(folder)


@pytest.fixture(autouse=True)
def _unlaid(monkeypatch: pytest.MonkeyPatch) -> None:
    # Laying out takes seconds, and is tested with figures.
    monkeypatch.setattr(style, "lay_out", lambda _: None)


@pytest.mark.parametrize("name", SECTION_FIGURES)
def test_each_section_has_a_picture_with_the_verdict_on_every_engine(wishes, name):
    figure = SECTION_FIGURES[name](wishes)
    said = " ".join(text.get_text() for axes in figure.axes for text in axes.texts)
    assert "ghostball" in said
    if name != "paper-section-6-1":
        assert "unsupported: no " in said


def test_the_papers_rule_turns_backwards_and_about_the_other_axis_falls_behind(wishes):
    printed, mended = RULES
    off = turned_off(*our_shot(wishes, "wall-bounce"))
    assert off[printed][1].max() > 3.0
    # The rule errs by v dt / 2 R for each path that ends: at most 0.3 rad.
    assert 1e-3 < off[mended][1].max() < 1.0
    # A sliding ball rotates differently from a rolling ball, about any axis in the plane.
    assert turned_off(*our_shot(wishes, "masse"))[mended][1].max() > 2.0
