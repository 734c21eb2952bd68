"""Fails where a figure or the report shows other errors, times or orders than were measured."""

import json

import numpy as np
import pytest

from ghostball.engine import GhostballError
from ghostball.reports import gallery_pictures, style, write_gallery, write_report
from ghostball.reports.precision_figure import (
    FLOOR,
    draw_against_time,
    draw_against_work,
    draw_precision,
)
from ghostball.reports.precision_text import best_text, duration_text, legend_text, reach_text
from ghostball.validation.bench import PrecisionMeasurement, measurements
from ghostball.validation.bench._observed import observed_in
from ghostball.validation.bench.measurements import save
from ghostball.validation.bench.precision import LeftOut, PrecisionCurve, PrecisionPoint, Reach
from ghostball.validation.results.store import Results

ENVIRONMENT = {"cpu": "a | b", "cores": 2, "date": "2026-01-02T03:04:05+00:00"}


def point(engine, seconds, error, *, step=None, scene="cut", true_course=True):
    return PrecisionPoint(
        scene=scene,
        title="A cut",
        truth="closed form",
        engine=engine,
        label=engine if step is None else f"{engine}:dt={step}",
        step=step,
        seconds=seconds,
        seconds_median=seconds,
        samples=4,
        error=error,
        error_low=0.5 * error,
        error_high=2.0 * error,
        work_name="events" if step is None else "steps",
        work=3 if step is None else round(4.0 / step),
        exact=step is None,
        true_course=true_course,
    )


def reach(*hows):
    targets = (1e-3, 1e-6, 1e-9)
    return tuple(
        Reach(target=t, how=how, seconds=None if how == "never" else 7.0 / t)
        for t, how in zip(targets, hows, strict=True)
    )


MEASURED = PrecisionMeasurement(
    environment=ENVIRONMENT,
    rounds=4,
    points=[
        point("ghostball", 4e-6, 0.0),
        point("pymunk", 1e-2, 2e-2, step=0.01, true_course=False),
        point("pymunk", 2e-2, 1e-2, step=0.005),
        point("ghostball", 5e-6, 1e-15, scene="bounce"),
    ],
    curves=[
        PrecisionCurve(
            scene="cut",
            engine="ghostball",
            order=None,
            order_note="no step: a point",
            reach=reach("measured", "measured", "measured"),
        ),
        PrecisionCurve(
            scene="cut",
            engine="pymunk",
            order=1.02,
            order_note="0.9 to 1.1 | fit",
            reach=reach("measured", "extrapolated", "never"),
        ),
    ],
    left_out=[LeftOut(scene="bounce", engine="pymunk", why="has | legs")],
)


@pytest.fixture
def with_precision(small_folder):
    save(MEASURED, small_folder / "precision.json", "--out")
    return small_folder


def bars_of(axes):
    return {bar.get_label(): bar for bar in axes.containers}


def test_each_scene_has_a_panel_and_each_engine_a_line_with_its_range():
    with style.drawing():
        figure = draw_against_time(MEASURED)
        assert [axes.get_title(loc="left") or axes.get_title() for axes in figure.axes] == [
            "cut",
            "bounce",
        ]
        bars = bars_of(figure.axes[0])
    assert set(bars) == {"ghostball", "pymunk"}
    line, _, (ranges,) = bars["pymunk"]
    assert list(line.get_xdata()) == [1e-2, 2e-2]
    assert list(line.get_ydata()) == [2e-2, 1e-2]
    assert np.allclose(ranges.get_segments()[0][:, 1], [1e-2, 4e-2])
    assert figure.axes[0].get_xscale() == figure.axes[0].get_yscale() == "log"


def test_an_error_of_nothing_is_drawn_at_the_floor_and_said():
    with style.drawing():
        figure = draw_against_time(MEASURED)
        line, *_ = bars_of(figure.axes[0])["ghostball"]
    assert list(line.get_ydata()) == [FLOOR]
    assert figure.axes[0].get_ylim()[0] < FLOOR
    assert "0, or below 1e-17 m" in [text.get_text() for text in figure.axes[0].texts]


def test_work_is_the_other_axis_and_says_what_it_counts():
    with style.drawing():
        figure = draw_against_work(MEASURED)
        line, *_ = bars_of(figure.axes[0])["pymunk"]
    assert list(line.get_xdata()) == [400, 800]
    assert figure.axes[0].get_xlabel() == "steps; of engines without a step: events"


def test_another_course_is_an_open_marker():
    with style.drawing():
        axes = draw_against_time(MEASURED).axes[0]
    (open_ones,) = [
        line
        for line in axes.lines
        if line.get_markerfacecolor() == "white" and len(line.get_xdata())
    ]
    assert list(open_ones.get_xdata()) == [1e-2]


def test_the_legend_has_the_orders():
    with style.drawing():
        (legend,) = draw_against_time(MEASURED).legends
    texts = [text.get_text() for text in legend.get_texts()]
    assert texts == ["ghostball: no step: a point", "pymunk: order 1"]
    beside = MEASURED.curves[1].model_copy(update={"limit_beside": 0.1, "order": 2.0})
    assert legend_text("pymunk", [MEASURED.curves[1], beside]) == (
        "pymunk: order 1 to 2, beside the truth"
    )


def test_the_least_error_is_the_same_number_in_words_and_in_the_history():
    """Breaks where one is of the worst phase and the other a median."""
    assert best_text(MEASURED.points[1:3]) == "20 mm in 20 ms"
    seen = observed_in("precision", MEASURED.model_dump_json(by_alias=True)).values
    assert seen["cut/pymunk/least_error"].value == MEASURED.points[2].error_high == 2e-2


def test_times_are_marked_by_how_they_are_known():
    measured, extrapolated, never = MEASURED.curves[1].reach
    assert reach_text(measured) == "117 min"
    assert reach_text(extrapolated) == "~ 81 days"
    assert reach_text(never) == "never"


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (4e-6, "4 µs"),
        (119.0, "119 s"),
        (121.0, "2.02 min"),
        (8e3, "2.22 h"),
        (1e12, "31,700 years"),
    ],
)
def test_durations_have_units_that_suit_them(seconds, text):
    assert duration_text(seconds) == text


def test_nothing_is_drawn_of_nothing(small_folder):
    assert draw_against_time(MEASURED.model_copy(update={"points": ()})) is None
    assert draw_precision(Results.open(small_folder)) is None


def test_the_report_has_a_section_where_it_was_measured(with_precision):
    text = write_report(with_precision).read_text(encoding="utf-8")
    section = text.partition("## What time buys")[2].partition("## Environment")[0]
    assert "figures/precision.svg" in section
    assert "figures/precision-work.svg" in section
    assert "| `pymunk` | 1.02 | 117 min | \\~ 81 days | never |" in section
    assert "0.9 to 1.1 \\| fit" in section
    assert "bounce, `pymunk` is left out: has \\| legs" in section
    assert "interrupted" not in section
    assert (with_precision / "figures" / "precision-work.png").exists()


@pytest.mark.usefixtures("without_run_figures")
def test_the_report_says_what_is_wrong_with_a_measurement(with_precision):
    part = MEASURED.model_copy(update={"interrupted": True, "quick": True})
    save(part, with_precision / "precision.json", "--out")
    text = write_report(with_precision).read_text(encoding="utf-8")
    assert "This measurement was interrupted." in text
    assert "its times mean nothing" in text


@pytest.mark.usefixtures("without_run_figures")
def test_a_report_without_a_measurement_has_no_section(small_folder):
    assert "## What time buys" not in write_report(small_folder).read_text(encoding="utf-8")


def test_a_damaged_measurement_is_an_error_that_names_it(with_precision):
    (with_precision / "precision.json").write_text(json.dumps({"kind": "precision"}))
    with pytest.raises(GhostballError, match=r"precision\.json: `environment`"):
        write_report(with_precision)


def test_the_gallery_draws_the_committed_measurement_if_there_is_one(
    results_folder, tmp_path, monkeypatch
):
    monkeypatch.setattr(measurements, "STORE", tmp_path / "store")
    monkeypatch.setattr(gallery_pictures, "GALLERY", {})  # what else it draws is not the question
    names = {path.name for path in write_gallery(results_folder, tmp_path / "without")}
    assert "precision.png" not in names
    save(MEASURED, tmp_path / "store" / "some-machine" / "precision.json", "--store")
    names = {path.name for path in write_gallery(results_folder, tmp_path / "with")}
    assert {"precision.png", "precision.svg"} <= names


def test_a_legend_of_many_engines_is_within_the_figure():
    curve = MEASURED.curves[1].model_copy(update={"limit_beside": 0.1, "order": 0.63})
    labels = [f"pybullet:mode=landed,iterations={k}" for k in range(9)]
    many = MEASURED.model_copy(
        update={
            "points": [
                point(label, 1e-2, 1e-3, step=0.01, scene=scene)
                for label in labels
                for scene in ("a", "b", "c")
            ],
            "curves": [curve.model_copy(update={"engine": label}) for label in labels]
            + [curve.model_copy(update={"engine": label, "order": 1.13}) for label in labels],
        }
    )
    with style.drawing():
        figure = draw_against_time(many)
        figure.draw_without_rendering()
        (legend,) = figure.legends
        box = legend.get_window_extent()
    assert box.x0 >= 0.0
    assert box.x1 <= figure.bbox.width
