"""The report's section and figure on where differences come from, and how parts are written."""

from dataclasses import replace

import pytest

from reports import style, write_report
from reports.attribution_figure import draw_attribution, draw_parts
from reports.attribution_text import backward_text, order_text, part_text, share_text
from validation.attribution import Attribution, BackwardError, Part, write_attributions
from validation.records import definition_hash
from validation.store import ResultsFolder

STROKE = BackwardError("cue", -1e-3, -5.2e-5, 4e-4, "certified", 3)
DIVIDED = Attribution(
    "stop",
    "pymunk",
    "pymunk",
    "attributed",
    "certified",
    difference=4e-3,
    model=Part(1e-3, 2e-4, 0.25),
    discretisation=Part(3e-3, 2e-4, 0.75),
    rounding=1e-15,
    approximations=("cushions | that mirror: no",),
    step=1e-3,
    phases=(3, 2, 1, 1),
    order=1.04,
    order_low=0.9,
    order_high=1.2,
    order_used=1.0,
    backward=STROKE,
)


def stored(folder, *found):
    results = ResultsFolder.load(folder)
    hashes = {case.label: definition_hash(case.definition) for case in results.cases}
    write_attributions(folder, [replace(one, definition_hash=hashes[one.label]) for one in found])


def test_parts_order_and_stroke_in_words():
    assert part_text(DIVIDED.model) == "1 mm ± 200 µm"
    assert part_text(None) == "–"
    assert share_text(DIVIDED, DIVIDED.model) == "25 %"
    assert share_text(replace(DIVIDED, difference=1e-4), DIVIDED.model) == ""
    assert order_text(DIVIDED) == "1 (0.9 to 1.2)"
    wide = replace(DIVIDED, order=0.2, order_low=0.2, order_high=3.9)
    assert order_text(wide) == "1, assumed (any of 0.2 to 3.9 fits)"
    assert order_text(replace(DIVIDED, order=None, flat=True)) == "no matter what step"
    assert backward_text(DIVIDED) == (
        "as if played 0.003° to the right and 0.1 % softer; 400 µm of 4 mm is left unexplained"
    )
    other = replace(STROKE, speed=0.02, turn=0.0)
    assert "as if played 2 % harder;" in backward_text(replace(DIVIDED, backward=other))
    still = replace(STROKE, speed=0.0, turn=0.0)
    assert "no other speed or direction" in backward_text(replace(DIVIDED, backward=still))
    assert backward_text(replace(DIVIDED, backward=None, no_backward="two are fast")) == (
        "two are fast"
    )


def test_the_report_has_the_section_where_the_folder_has_the_file(small_folder):
    text = write_report(small_folder).read_text()
    assert "Where differences come from" not in text
    lost = replace(
        DIVIDED,
        label="pymunk:mode=landed",
        outcome="not converged",
        reason="no | limit",
        model=None,
        discretisation=None,
    )
    stored(small_folder, DIVIDED, lost)
    text = write_report(small_folder).read_text()
    assert "## Where differences come from" in text
    row = "| `pymunk` | 4 mm at the end | 1 mm ± 200 µm | 25 % | 3 mm ± 200 µm | 75 % |"
    assert row in text
    assert "| `pymunk:mode=landed` | 4 mm at the end | not converged |" in text
    assert "no \\| limit" in text
    assert "cushions \\| that mirror" in text
    assert (small_folder / "figures" / "attribution.png").exists()


def test_attributions_of_other_scenes_or_code_are_not_shown(small_folder):
    stored(small_folder, replace(DIVIDED, code_hash="of another version"))
    assert "Where differences" not in write_report(small_folder).read_text()
    assert draw_attribution(ResultsFolder.load(small_folder)) is None


@pytest.mark.parametrize("found", [[], [replace(DIVIDED, model=None)]])
def test_nothing_divided_is_not_drawn(found):
    assert draw_parts(found) is None


def test_each_engine_has_a_panel_and_each_scene_a_row():
    found = [DIVIDED, replace(DIVIDED, label="pybullet"), replace(DIVIDED, scene="head-on")]
    with style.drawing():
        figure = draw_parts(found)
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["pymunk", "pybullet"]
    assert [tick.get_text() for tick in figure.axes[0].get_yticklabels()] == ["stop", "head-on"]
    assert [len(axes.patches) for axes in figure.axes] == [4, 2]
