"""Fails where the page shows another measurement than the one in the folder, or hides a point."""

import re

import pytest

from ghostball.reports.page.measured import cost_html
from ghostball.reports.page.precision import MARKERS, OPEN, engines_of_page
from ghostball.validation.bench import PrecisionMeasurement
from ghostball.validation.bench.precision import LeftOut, PrecisionCurve, PrecisionPoint, Reach
from ghostball.validation.results.store import Results


def point(engine, step, seconds, error, **changed):
    fields = {
        "scene": "stop",
        "title": "t",
        "truth": "closed form",
        "engine": engine,
        "label": engine if step is None else f"{engine},dt={step}",
        "step": step,
        "seconds": seconds,
        "seconds_median": seconds,
        "samples": 3,
        "error": error,
        "error_low": error / 2.0,
        "error_high": error * 2.0,
        "work_name": "steps",
        "work": 10,
        "exact": step is None,
    }
    return PrecisionPoint(**(fields | changed))


@pytest.fixture
def results(small_folder):
    measured = PrecisionMeasurement(
        environment={"cpu": "a | b", "date": "2026-01-01"},
        rounds=3,
        points=(
            point("ghostball", None, 1e-5, 0.0),
            point("certified", None, 1e-3, 1e-17),
            point("pymunk", 1e-3, 1e-2, 1e-3),
            point("pymunk", 5e-4, 2e-2, 5e-4, true_course=False),
        ),
        curves=(
            PrecisionCurve(
                scene="stop",
                engine="pymunk",
                order=1.0,
                order_note="",
                reach=(Reach(target=1e-3, seconds=1e-2, how="measured"),),
            ),
        ),
        left_out=(LeftOut(scene="stop", engine="pybullet", why="<b>no table</b>"),),
    )
    (small_folder / "precision.json").write_text(measured.model_dump_json(by_alias=True))
    return Results.open(small_folder)


def test_every_point_is_drawn_and_one_of_another_course_is_open(results):
    html = cost_html(results)
    assert "pymunk,dt=0.001: 1 mm in 10 ms" in html
    assert "pymunk,dt=0.0005: 500 µm in 20 ms; other collisions than the true ones" in html
    assert re.search(r"○<title>pymunk,dt=0\.0005", html)
    assert re.search(r"●<title>pymunk,dt=0\.001", html)
    assert "ghostball: 0 in 10 µs" in html
    assert "no work-precision measurement" not in html.lower()


def test_tables_and_what_is_left_out_come_from_the_report(results):
    html = cost_html(results)
    assert "Time to reach: stop" in html
    assert "&lt;b&gt;no table&lt;/b&gt;" in html


def test_an_engine_of_the_measurement_alone_has_a_colour_too(results):
    assert engines_of_page(results)[-1] == "certified"
    assert f"var(--engine-{len(engines_of_page(results)) - 1})" in cost_html(results)


def test_every_sign_has_an_open_one():
    assert set(OPEN) == set(MARKERS.values())
