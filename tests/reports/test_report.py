"""Fails where the report hides a verdict or a reason, or a bad folder gives no clear error."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from stored_results import edit_document, edit_records, in_database

from ghostball.engine import GhostballError, SampledTrajectory, Status
from ghostball.engine.result import EVENT_DTYPE, Result, initial_state
from ghostball.reports import (
    PAGE,
    film,
    plot_result,
    summary_markdown,
    summary_text,
    write_report,
)
from ghostball.reports.junit import junit_xml
from ghostball.reports.markdown import counted_section, headline
from ghostball.reports.markdown_scene import collision_text, remarks
from ghostball.reports.shots import load_shot
from ghostball.validation.results.store import CaseRecord, Results, ResultsWriter


@pytest.fixture(scope="module")
def results(module_folder):
    """Three scenes on seven engines."""
    return Results.open(module_folder)


def cases_of(results, scene):
    return [case for case in results.cases if case.scene == scene]


def test_the_headline_counts_verdicts_and_names_what_is_wrong(results):
    text = headline(results)
    assert (
        "3 scenes on 5 engines in 7 configurations: **8 passed, 6 failed**, "
        "**1 did not finish**, 0 keep their limits" in text
    )
    assert "3 not representable" in text
    assert "Not right: [stop](#stop) on `pymunk:config=default`, [stop]" in text
    assert "[head-on](#head-on) on `newcomer:dt=1e-3`" in text
    assert "left unsolved" not in text


def test_the_true_counts_are_said_with_who_counts_them(results):
    text = collision_text(cases_of(results, "head-on"))
    assert "Collisions in truth: **1 ball-ball**. Right: `ghostball`, `pymunk`," in text
    assert "Wrong: `paper-discrete` 7 ball-ball." in text
    text = collision_text(cases_of(results, "break-7"))
    assert (
        "Collisions by our engine (not independent): **2 ball-ball**. The same: `pymunk`," in text
    )
    assert "Different: `paper-discrete` 7 ball-ball." in text


def test_every_failure_has_its_reason(results):
    text = remarks(cases_of(results, "head-on"))
    assert (
        "- **`paper-discrete` fails**: rest_error_max must be <= 0.005 m, got 0.03 m "
        "(a tenth of a ball)" in text
    )
    assert "- `pybullet` not representable: no table \\| with legs" in text
    assert "- `newcomer:dt=1e-3` did not finish: division by zero" in text


def test_what_a_run_counted_is_shown(results):
    # Breaks where an approximation or a repair stays in the results unseen.
    section = counted_section(results)
    joint = "impacts of one instant, resolved together"
    assert f"| `ghostball` | {joint} | 2 | [break-7](#break-7) 2 |" in section
    pulls = "overlapping balls pulled apart"
    where = ", ".join(f"[{scene}](#{scene}) 3" for scene in ("break-7", "head-on", "stop"))
    assert f"| `paper-discrete` | {pulls} | 9 | {where} |" in section
    assert "press each other |" not in section  # none was
    assert f"- `ghostball` counted 2 {joint}" in remarks(cases_of(results, "break-7"))


def test_an_unsolved_contact_step_is_told_at_the_top(small_folder):
    edit_records(
        small_folder, lambda text: text.replace('"steps":50', '"unsolved_contact_steps":1')
    )
    assert "**3 sustained or joint contacts left unsolved.**" in headline(
        Results.open(small_folder)
    )


def test_a_run_that_was_killed_is_reported_and_said_to_be(small_folder):
    in_database(small_folder, "DELETE FROM records WHERE id = (SELECT max(id) FROM cases)")
    edit_document(small_folder, "suite", state="running")
    text = headline(Results.open(small_folder))
    wanted = "**This run is not complete**: it is still running, or was killed; 2 of 3 cases are"
    assert wanted in text
    assert "1 scene on 2 engines: " in text


def drawn(folder):
    return {path.name for path in (folder / "figures").glob("*")}


def test_pictures_are_those_that_are_asked_for_and_the_page_holds_or_names_them(small_folder):
    seen = []
    page = write_report(small_folder, progress=lambda *part: seen.append(part))
    assert seen == [(1, 1, "part of report.html on scene stop")]
    assert drawn(small_folder) == {"stop-sheet.png"}
    text = page.read_text(encoding="utf-8")
    assert '<a href="figures/stop-sheet.png">' in text
    assert text == write_report(small_folder, figures="svg").read_text(encoding="utf-8")
    assert drawn(small_folder) == {"stop-sheet.png", "stop-sheet.svg"}
    assert text == write_report(small_folder).read_text(encoding="utf-8")
    assert drawn(small_folder) == {"stop-sheet.png"}
    text = write_report(small_folder, figures="none").read_text(encoding="utf-8")
    assert drawn(small_folder) == set()
    assert "stop-sheet" not in text


def test_another_process_draws_the_same(small_folder):
    (small_folder / "figures").mkdir()
    for name in ("gone-sheet.png", "mine.png"):  # of a scene that is no more, and somebody's
        (small_folder / "figures" / name).touch()

    def contents():
        paths = [small_folder / PAGE, *(small_folder / "figures").iterdir()]
        return {path.name: path.read_bytes() for path in paths}

    seen = []
    write_report(small_folder, figures="svg")
    one = contents()
    write_report(small_folder, progress=lambda *part: seen.append(part), jobs=2, figures="svg")
    assert seen[-1][0] == seen[-1][1] == len(seen)
    assert contents() == one
    assert one.keys() == {PAGE, "stop-sheet.png", "stop-sheet.svg", "mine.png"}


def test_an_engine_that_is_unavailable_has_no_settings_and_costs_nothing(small_folder, tmp_path):
    # On Python 3.12 there is no pybullet: the default run has cases without their engine.
    results = Results.open(small_folder)
    missing = CaseRecord(
        scene="stop",
        title="One ball",
        tags=(),
        definition=results.cases[0].definition,
        label="pybullet",
        engine="pybullet",
        outcome="unavailable",
        reason="pybullet isn't installed",
    )
    writer = ResultsWriter(tmp_path / "without")
    settings = {"ghostball": {}, "pymunk": {"dt": 1e-3}, "pybullet": None}
    writer.begin({"scenes": ["stop"], "engines": list(settings), "engine_settings": settings})
    for case in (results.cases[0], replace(results.cases[1], settings={"dt": 1e-3}), missing):
        writer.write((case, None if case is missing else results.motion(case)))
    writer.finish("complete")
    page = write_report(writer.path, figures="none").read_text(encoding="utf-8")
    assert "<code>pybullet</code> unavailable: pybullet isn't installed" in page
    settings = page[page.index("Engines with all settings") :]
    assert "<code>pybullet</code><td>unavailable here\n" in settings
    assert "<code>ghostball</code><td>none\n" in settings
    assert "dt = 0.001" in settings
    without = Results.open(writer.path)
    assert "– unavailable" in summary_markdown(without)
    assert "stop: warning: pybullet: unavailable: pybullet isn't" in summary_text(without)
    assert "pybullet isn't installed" in junit_xml(without.cases)


def test_a_folder_that_holds_no_results(tmp_path):
    with pytest.raises(GhostballError, match="no such results folder"):
        write_report(tmp_path / "nowhere")
    with pytest.raises(GhostballError, match="not a results folder"):
        write_report(tmp_path)


@pytest.fixture
def result(results_folder):
    shot = load_shot(Results.open(results_folder), "head-on")
    motion, state = shot.ours.motion, initial_state(shot.scene)
    return Result(
        engine="ghostball",
        settings={},
        scene=shot.scene,
        status=Status.REST,
        final_state=state,
        rest_time=3.0,
        collision_counts={"ball-ball": 1, "ball-cushion": 0},
        work={},
        wall_time=0.0,
        events=np.array([(1.0, 0, 0, 1)], dtype=EVENT_DTYPE),
        trajectory=SampledTrajectory(
            motion.times, motion.positions, motion.velocities, motion.angular_velocities
        ),
    )


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_one_result_is_drawn(result, tmp_path, ending):
    path = plot_result(result, tmp_path / f"shot.{ending}")
    assert path.stat().st_size > 5_000


def test_a_film_shows_the_shot_to_its_end_and_no_longer_than_it_may(result, tmp_path, monkeypatch):
    monkeypatch.setattr(film, "LONGEST", 0.4)
    with Image.open(plot_result(result, tmp_path / "shot.gif")) as shot:
        assert shot.n_frames == 2 + int(0.4 * film.FRAMES_A_SECOND)
        assert shot.info["duration"] == 1000 / film.FRAMES_A_SECOND
        first = np.asarray(shot.convert("RGB"))
        shot.seek(shot.n_frames - 1)
        assert np.any(first != np.asarray(shot.convert("RGB")))


def test_a_film_as_mp4_without_ffmpeg_says_what_to_do(result, tmp_path, monkeypatch):
    monkeypatch.setattr("matplotlib.animation.FFMpegWriter.isAvailable", lambda: False)
    with pytest.raises(GhostballError, match=r"needs ffmpeg on the PATH\. Install it"):
        plot_result(result, tmp_path / "shot.mp4")
