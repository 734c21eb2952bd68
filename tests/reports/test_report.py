"""Fails where the report hides a verdict or a reason, or a bad folder gives no clear error."""

import re
from dataclasses import replace

import pytest
from stored_results import damage_motions, edit_document, edit_records, in_database

from ghostball.engine import GhostballError, SampledTrajectory, Status
from ghostball.engine.result import EVENT_DTYPE, Result, initial_state
from ghostball.reports import (
    PAGE,
    plot_result,
    style,
    summary_markdown,
    summary_text,
    write_gallery,
    write_report,
)
from ghostball.reports.report import WHOLE_FIGURES
from ghostball.reports.shots import load_shot
from ghostball.validation.results.store import CaseRecord, Results, ResultsWriter
from ghostball.validation.suite.junit import write_junit


@pytest.fixture(scope="module")
def report(module_folder):
    """One report for all that only read it: the folder and the text."""
    return module_folder, write_report(module_folder).read_text(encoding="utf-8")


def test_verdicts_come_first(report):
    _, text = report
    assert text.index("## Verdicts") < text.index("## What is true here") < text.index("## Scenes")
    assert text.index("## Scenes") < text.index("## Environment")
    assert (
        "3 scenes on 5 engines in 7 configurations: **8 passed, 6 failed**, "
        "**1 did not finish**, 0 keep their limits" in text
    )
    assert "3 not representable" in text
    top = text[: text.index("## Verdicts")]
    assert "Not right: [stop](#stop) on `pymunk:config=default`, [stop]" in top
    assert "[head-on](#head-on) on `newcomer:dt=1e-3`" in top
    assert (
        "| [stop](#stop) | ✓ 0 | ✓ 2 mm | ✓ 400 nm | **✗ 90 mm** | – | **✗ 30 mm** | ○ (1 mm) |"
        in (text)
    )
    assert "| [break-7](#break-7) | ref | ✓ 2 mm |" in text
    assert "– not representable; ! did not finish. Numbers: largest rest error" in text


def test_the_true_counts_are_said_with_who_counts_them(report):
    _, text = report
    assert "Collisions in truth: **1 ball-ball**. Right: `ghostball`, `pymunk`," in text
    assert "Wrong: `paper-discrete` 7 ball-ball." in text
    assert (
        "Collisions by our engine (not independent): **2 ball-ball**. The same: `pymunk`," in text
    )
    assert "Different: `paper-discrete` 7 ball-ball." in text


def test_every_failure_has_its_reason(report):
    _, text = report
    assert (
        "- **`paper-discrete` fails**: `rest_error_max` is 0.03 m, must be at most 0.005 m "
        "(a tenth of a ball)" in text
    )
    assert "- `pybullet` not representable: no table \\| with legs" in text
    assert "- `newcomer:dt=1e-3` did not finish: division by zero" in text


def test_every_limit_is_printed_with_its_reason(report):
    # Breaks where a passed check can't be questioned.
    _, text = report
    assert "| `pymunk` | `rest_error_max` | 2 mm | at most 5 mm | ✓ | a tenth of a ball |" in text
    assert "| `paper-discrete` | `rest_error_max` | 30 mm | at most 5 mm | ✗ |" in text
    assert text.count("<details>") == text.count("</details>") == 6


def test_what_a_run_counted_is_shown(report):
    # Breaks where an approximation or a repair stays in the results unseen.
    _, text = report
    section = text[text.index("## What the runs counted") : text.index("## Scenes")]
    joint = "impacts of one instant, resolved together"
    assert f"| `ghostball` | {joint} | 2 | [break-7](#break-7) 2 |" in section
    pulls = "overlapping balls pulled apart"
    where = ", ".join(f"[{scene}](#{scene}) 3" for scene in ("break-7", "head-on", "stop"))
    assert f"| `paper-discrete` | {pulls} | 9 | {where} |" in section
    assert "press each other |" not in section  # none was
    assert f"- `ghostball` counted 2 {joint}\n" in text
    assert "| `ghostball` | events 9, joint impacts 2, contact steps 0 |" in text
    assert "left unsolved" not in text


@pytest.mark.usefixtures("without_run_figures")
def test_an_unsolved_contact_step_is_told_at_the_top(small_folder):
    edit_records(
        small_folder, lambda text: text.replace('"steps":50', '"unsolved_contact_steps":1')
    )
    text = write_report(small_folder).read_text(encoding="utf-8")
    assert "**3 sustained or joint contacts left unsolved.**" in text[: text.index("## Verdicts")]


def test_a_case_that_did_not_finish_has_a_column_of_its_own(report):
    _, text = report
    assert "| ✓ | ≈ | ✗ | did not finish | not representable |" in text
    assert "| `newcomer:dt=1e-3` | 0 | 0 | 0 | 1 | 0 |" in text


@pytest.mark.usefixtures("without_run_figures")
def test_a_run_that_was_killed_is_reported_and_said_to_be(small_folder):
    in_database(small_folder, "DELETE FROM cases WHERE id = (SELECT max(id) FROM cases)")
    edit_document(small_folder, "suite", state="running")
    text = write_report(small_folder).read_text(encoding="utf-8")
    wanted = "**This run is not complete**: it is still running, or was killed; 2 of 3 cases are"
    assert wanted in text
    assert "1 scene on 2 engines: " in text


@pytest.mark.usefixtures("without_run_figures")
def test_nothing_is_called_rest_where_nothing_rests(small_folder):
    edit_records(small_folder, lambda text: text.replace('"status":"rest"', '"status":"t-max"'))
    text = write_report(small_folder, figures=True).read_text(encoding="utf-8")
    section = text[text.index("### stop") : text.index("## Environment")]
    assert "| end error, max (in brackets: not judged) | rms | end time [s] |" in section
    assert "rest time" not in section
    assert "Error at the end against the limits" in section


def linked(text):
    return set(re.findall(r"figures/[\w.-]+\.(?:png|svg)", text))


def drawn(folder):
    return {f"figures/{path.name}" for path in (folder / "figures").glob("*")}


def test_every_figure_that_is_linked_exists_and_no_other(report):
    folder, text = report
    assert linked(text) == drawn(folder)
    assert "figures/verdicts.svg" in linked(text)
    assert "-paths" not in text
    assert text.count("`ghostball report --figures` on this folder draws them") == 1


def test_figures_of_scenes_are_drawn_where_asked_for_and_go_with_the_next_report(small_folder):
    seen = []
    report = write_report(small_folder, progress=lambda *part: seen.append(part), figures=True)
    count = len(WHOLE_FIGURES) + 2
    assert [(done, of) for done, of, _ in seen] == [(done, count) for done in range(1, count + 1)]
    assert {what for *_, what in seen} == {
        *(f"figure {kind}" for kind in WHOLE_FIGURES),
        "stop",
        "figures of stop",
    }
    assert linked(report.read_text()) == drawn(small_folder)
    assert {"figures/stop-paths.svg", "figures/stop-energy.png"} <= drawn(small_folder)
    assert "--figures" not in report.read_text()
    assert linked(write_report(small_folder).read_text()) == drawn(small_folder)
    assert not any("stop-" in name for name in drawn(small_folder))


@pytest.mark.usefixtures("without_run_figures")
def test_another_process_draws_the_same(small_folder):
    stale = small_folder / "figures" / "gone-paths.png"
    stale.parent.mkdir()
    stale.touch()
    somebodys = small_folder / "figures" / "mine.png"
    somebodys.touch()

    def contents():
        paths = [small_folder / PAGE, small_folder / "report.md"]
        paths += (small_folder / name for name in drawn(small_folder))
        return {path.name: path.read_bytes() for path in paths}

    seen = []
    write_report(small_folder, figures=True)
    one = contents()
    write_report(small_folder, progress=lambda *part: seen.append(part), jobs=2, figures=True)
    assert [(done, of) for done, of, _ in seen] == [(1, 2), (2, 2)]
    assert contents() == one
    assert len(one) == 9  # the page, the text, three figures twice, and what isn't ours
    assert not stale.exists()
    assert not (small_folder / "report.md.part").exists()


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
        writer.write(case, None if case is missing else results.motion(case))
    writer.finish("complete")
    text = write_report(writer.path, figures=True).read_text(encoding="utf-8")
    assert "| `engine_settings.pybullet` | unavailable here |" in text
    assert "- `pybullet` unavailable: pybullet isn't installed" in text
    assert linked(text) == drawn(writer.path)
    page = (writer.path / PAGE).read_text(encoding="utf-8")
    settings = page[page.index("Engines with all settings") :]
    assert "<code>pybullet</code><td>unavailable here\n" in settings
    assert "<code>ghostball</code><td>none\n" in settings
    assert "dt = 0.001" in settings
    without = Results.open(writer.path)
    assert "– unavailable" in summary_markdown(without, None)
    assert "stop: warning: pybullet: unavailable: pybullet isn't" in summary_text(without, None)
    write_junit(without.cases, tmp_path / "junit.xml")
    assert "pybullet isn't installed" in (tmp_path / "junit.xml").read_text(encoding="utf-8")


def test_tables_are_whole(report):
    _, text = report
    for table in re.findall(r"(?:^\|.*\n)+", text, flags=re.MULTILINE):
        columns = {len(re.findall(r"(?<!\\)\|", line)) for line in table.splitlines()}
        assert len(columns) == 1, table
    assert "| `cpu` | a \\| b |" in text
    assert "| `versions.numpy` | 2.0 |" in text


def test_a_folder_that_holds_no_results(tmp_path):
    with pytest.raises(GhostballError, match="no such results folder"):
        write_report(tmp_path / "nowhere")
    with pytest.raises(GhostballError, match="not a results folder"):
        write_report(tmp_path)


def test_a_damaged_motion_leaves_the_old_report(small_folder):
    (small_folder / "report.md").write_text("old")
    damage_motions(small_folder)
    with pytest.raises(GhostballError, match=r"the motion of .* is damaged"):
        write_report(small_folder)
    assert (small_folder / "report.md").read_text() == "old"


def test_an_unwritable_folder_is_an_error_that_names_it(small_folder):
    (small_folder / "figures").write_text("a file in the way")
    with pytest.raises(GhostballError, match="figures: can't write the report"):
        write_report(small_folder)


def test_an_unknown_scene_names_those_there_are(results_folder):
    with pytest.raises(GhostballError, match=r'"nonsense".*stop, head-on'):
        load_shot(Results.open(results_folder), "nonsense")


def test_the_gallery_is_complete(results_folder, tmp_path, monkeypatch):
    # How a figure is written is tested with figures; drawing all of these takes seconds.
    monkeypatch.setattr(style, "lay_out", lambda _: None)
    monkeypatch.setattr(style, "save_one", lambda figure, path, _: path.write_text(str(figure)))
    folder = tmp_path / "new" / "gallery"
    written = write_gallery(results_folder, folder)
    assert sorted(written) == sorted(folder.iterdir())
    names = {path.stem for path in written}
    assert len(written) == len(names) * len(style.FORMATS)
    assert {f".{ending}" for ending in style.FORMATS} == {path.suffix for path in written}
    assert all(path.read_text().startswith("Figure(") for path in written)
    assert {"hero", "verdicts", "paper-figure-2"} <= names
    assert {"physics-deflection", "physics-throw"} <= names


def test_a_gallery_without_its_scenes_is_an_error(small_folder, tmp_path):
    with pytest.raises(GhostballError, match='"hero" needs scenes'):
        write_gallery(small_folder, tmp_path / "gallery")
    assert not (tmp_path / "gallery").exists()


@pytest.fixture
def result(results_folder):
    import numpy as np

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


def test_another_ending_is_refused(result, tmp_path):
    with pytest.raises(GhostballError, match=r"must end in \.png, \.svg, \.pdf, got 'shot.gif'"):
        plot_result(result, tmp_path / "shot.gif")
