"""The suite: every case ends as a record, whatever an engine does; interrupts keep what is done."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ghostball.validation.suite.case
import ghostball.validation.suite.suite
from ghostball.model import Ball, GhostballError, Scene
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.checks.criterion import Criterion
from ghostball.validation.checks.verdict import Verdict, verdict_of
from ghostball.validation.results.store import CaseRecord, Results, ResultsError
from ghostball.validation.suite.judge import Case
from ghostball.validation.suite.plan import criteria_beside_paths
from ghostball.validation.suite.suite import run_suite
from ghostball.validation.truth.closed_forms import has_closed_form

ENGINES = '''
"""Engines that misbehave, one setting for each way."""

import os
import time

import numpy as np

from ghostball.model import Result, Status
from ghostball.engine import simulate
from ghostball.model.features import EXACT, Capability, Feature
from ghostball.reference_adapters.base import EngineBase, EngineSettings


class Settings(EngineSettings):
    does: str = "run"
    shift: float = 0.0
    sees: float = 0.0


class Fake(EngineBase):
    name = "fake"
    Settings = Settings

    @property
    def capabilities(self):
        able = dict.fromkeys(Feature, EXACT)
        able[Feature.ROLLING] = Capability("approximate", "nearly")
        if self.settings.does == "refuse":
            able[Feature.ROLLING] = Capability("none", "it slips")
        return able

    def resolution(self, scene):
        return self.settings.sees

    def simulate(self, scene, *, record="rest"):
        self.check(scene)
        does = self.settings.does
        if does == "raise":
            raise RuntimeError("lost the \\x1b[31mballs")
        if does == "die":
            os._exit(7)
        if does == "hang":
            time.sleep(600)
        if does == "interrupt":
            raise KeyboardInterrupt
        if does == "exit":
            raise SystemExit(0)
        if does == "hand back a dict":
            return {}
        if does == "print":
            print("hello")
        truth = simulate(scene, record=record)
        shifted = truth.final_state._replace(
            positions=truth.final_state.positions + [self.settings.shift, 0.0, 0.0]
        )
        if does == "lose a ball":
            shifted.positions[0, 0, 1] = np.nan
        if does == "flatten":
            shifted = shifted._replace(positions=shifted.positions[:, :, :2])
        return Result(
            engine="ghostball" if does == "lie" else "fake",
            settings={},
            scene=scene.model_copy(update={"t_max": 9.0}) if does == "swap" else scene,
            status={
                "hand back": Status.INTERRUPTED,
                "give up": Status.FAILED,
                "stop": Status.STEP_LIMIT,
            }.get(does, truth.status),
            reason={"give up": "lost the cue", "stop": "too many steps"}.get(does, ""),
            final_state=shifted,
            rest_time=np.nan if does == "lose time" else truth.rest_time,
            collision_counts=truth.collision_counts,
            work={"steps": np.int64(3)},
            wall_time=0.5,
            events=None if does == "forget" else truth.events,
            trajectory=truth.trajectory,
        )


class Absent(Fake):
    name = "absent"

    @classmethod
    def unavailable(cls):
        return "not installed here"
'''

ENTRY_POINTS = """
[ghostball.engines]
fake = fake_engines:Fake
absent = fake_engines:Absent
"""


@pytest.fixture(autouse=True)
def fake_engines(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Install the fakes as anyone's package would be: worker processes must find them too."""
    site = tmp_path_factory.mktemp("site")
    (site / "fake_engines.py").write_text(ENGINES)
    package = site / "fake_engines-1.0.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: fake-engines\nVersion: 1.0\n")
    (package / "entry_points.txt").write_text(ENTRY_POINTS)
    monkeypatch.syspath_prepend(str(site))
    monkeypatch.delitem(sys.modules, "fake_engines", raising=False)
    return site


PROVED = ("energy_rise", "events_missing", "events_invented", "quality_factor")
"""What the law limits, of an engine that claims to err by rounding alone, whatever the truth."""


def scene(name: str = "roll") -> Scene:
    return Scene(name=name, balls=[Ball(id="cue", position=(0.0, 0.0), velocity=(1.0, 0.0))])


def limits(*engines: str, metric: str = "rest_error_max", at_most: float = 1e-6) -> Criteria:
    criterion = Criterion.model_validate(
        {"engines": engines, "metric": metric, "at_most": at_most, "reason": "by hand"}
    )
    return Criteria(criteria=(criterion,))


def by_label(cases: list[CaseRecord]) -> dict[str, CaseRecord]:
    return {case.label: case for case in cases}


# --- outcomes


def test_a_run_measures_judges_and_stores(tmp_path: Path) -> None:
    seen: list[tuple[str, int, int]] = []
    outcome = run_suite(
        [scene()],
        ["ghostball", "fake", "fake:shift=0.003"],
        tmp_path / "out",
        progress=lambda done, total, record: seen.append((record.label, done, total)),
        criteria={"roll": limits("ghostball", "fake").model_copy(update={"truth": "engine"})},
    )
    assert seen == [("ghostball", 1, 3), ("fake", 2, 3), ("fake:shift=0.003", 3, 3)]
    folder = Results.open(tmp_path / "out")
    assert folder.state == "complete"
    assert folder.labels == ["ghostball", "fake", "fake:shift=0.003"]
    assert folder.environment["engine_settings"]["fake"] == {
        "does": "run",
        "shift": 0.0,
        "sees": 0.0,
    }
    cases = by_label(folder.cases)
    # Our engine is the truth here, so it can't pass; the copy agrees, the shifted one is 3 mm off.
    verdicts = [
        next(check.passed for check in cases[label].checks if check.metric == "rest_error_max")
        for label in folder.labels
    ]
    assert verdicts == [None, True, False]
    # What is proved of the shot judges it all the same.
    proved = {check.metric: check.passed for check in cases["ghostball"].checks}
    assert proved == {"rest_error_max": None} | dict.fromkeys(PROVED, True)
    shifted = cases["fake:shift=0.003"]
    assert shifted.metrics["rest_error_max"] == pytest.approx(0.003, rel=1e-9)
    assert shifted.ball_errors == pytest.approx([0.003], rel=1e-9)
    assert (shifted.status, shifted.engine, shifted.work) == ("rest", "fake", {"steps": 3})
    assert shifted.approximations == ("rolling without slip: nearly",)
    assert shifted.load_scene() == scene()
    assert shifted.energy_initial == pytest.approx(0.7 * 0.170097, rel=1e-12)  # 7/10 m v^2
    assert shifted.energy_final == 0.0
    motion = folder.motion(shifted)
    assert motion is not None
    assert (
        len(motion.times) == 402
    )  # the uniform grid; its one event is at its end, and the instant before
    assert motion.times[-1] == shifted.rest_time
    counts = outcome.counts
    assert (counts.ran, counts.checks_passed, counts.checks_failed) == (3, 3 + len(PROVED), 1)
    assert counts.checks_reference == 1
    assert outcome.exit_status == 1


def test_what_an_engine_cannot_do_is_said_with_the_reason(tmp_path: Path) -> None:
    outcome = run_suite([scene()], ["fake:does=refuse", "absent"], tmp_path)
    refused, absent = outcome.cases
    assert (refused.outcome, refused.reason) == (
        "not-representable",
        "no rolling without slip (it slips)",
    )
    assert absent.outcome == "unavailable"
    assert "not installed here" in absent.reason
    assert outcome.exit_status == 4  # nothing was judged: that is no pass


def test_an_engine_of_another_package_is_held_to_the_resolution_that_it_states(
    tmp_path: Path,
) -> None:
    labels = ["fake:sees=1e-3", "fake:sees=1e-3,shift=0.1", "fake"]
    outcome = run_suite([scene()], labels, tmp_path)
    assert [verdict_of(case) for case in outcome.cases] == [
        Verdict.PASS,
        Verdict.FAIL,
        Verdict.LIMITS_HOLD,  # it claims to roll balls nearly right: how near, nobody knows
    ]
    assert all(case.accuracy is not None for case in outcome.cases)


def test_a_failure_is_kept_and_the_run_goes_on(tmp_path: Path) -> None:
    outcome = run_suite([scene()], ["fake:does=raise", "fake"], tmp_path)
    failed, fine = Results.open(tmp_path).cases
    assert (failed.outcome, failed.fault) == ("failed", "engine")
    assert "lost the" in failed.reason
    assert "Traceback" in failed.traceback
    assert (fine.outcome, fine.fault) == ("ran", "")
    assert outcome.exit_status == 1  # the engine failed, not ghostball


def test_what_raises_in_our_own_code_is_our_fault(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise ZeroDivisionError("by ten")

    monkeypatch.setattr("ghostball.validation.suite.judge.measure", fail)
    found = run_suite([scene()], ["fake"], tmp_path)
    assert (found.cases[0].fault, found.cases[0].reason) == (
        "ghostball",
        "ZeroDivisionError: by ten",
    )
    assert found.exit_status == 3


@pytest.mark.parametrize(
    ("does", "reason"),
    [
        ("lose a ball", "`rest_positions[0]` must be finite"),
        ("lose time", "`rest_time` must be finite and at least 0 s, got nan"),
        ("flatten", "`final_state.positions` must be an array of floats with shape (1, 1, 3)"),
        ("forget", '`events` must be there for record="trajectory", got None'),
        ("lie", "`engine` of the result must be 'fake', got 'ghostball'"),
        ("swap", "`scene` of the result must be the scene that was run"),
        ("hand back a dict", "must return a `Result`, got dict"),
        ("exit", "SystemExit: 0"),
    ],
)
def test_a_result_that_breaks_the_contract_is_a_failure_that_names_the_field(
    tmp_path: Path, does: str, reason: str
) -> None:
    # Breaks where nan reaches the figures, or an engine passes under another one's name.
    outcome = run_suite([scene()], [f"fake:does={does}", "fake"], tmp_path)
    cases = by_label(Results.open(tmp_path).cases)
    failed = cases[f"fake:does={does}"]
    assert failed.outcome == "failed"
    assert reason in failed.reason
    assert failed.rest_positions is None
    assert cases["fake"].outcome == "ran"
    assert outcome.exit_status == 1


def test_a_truth_that_fails_fails_its_scene_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(shot: Scene, *wanted: Any, **more: Any) -> object:
        if shot.name == "broken":
            raise ZeroDivisionError("no truth today")
        return real(shot, *wanted, **more)

    real = ghostball.validation.suite.case.truth_of
    monkeypatch.setattr(ghostball.validation.suite.case, "truth_of", broken)
    outcome = run_suite([scene("broken"), scene()], ["fake"], tmp_path)
    assert [case.outcome for case in outcome.cases] == ["failed", "ran"]
    assert "no truth today" in outcome.cases[0].reason
    assert "ZeroDivisionError" in outcome.cases[0].traceback


# --- what is refused before anything runs


@pytest.mark.parametrize(
    ("engines", "message"),
    [
        (["fkae"], "mean `fake`"),
        (["fake:shfit=1"], "`shfit` is not a setting"),
        (["fake", "fake"], "each engine must be given once"),
        ([], "at least one engine"),
    ],
)
def test_wrong_engines_are_refused(tmp_path: Path, engines: list[str], message: str) -> None:
    with pytest.raises(GhostballError, match=message):
        run_suite([scene()], engines, tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("criteria", "message"),
    [
        (limits("fkae"), "mean `fake`"),
        (limits("fake:shfit=1"), "names the setting `shfit`"),
        (Criteria(truth="closed-form"), "no closed form"),
    ],
)
def test_wrong_criteria_are_refused(tmp_path: Path, criteria: Criteria, message: str) -> None:
    # Two balls are hit at once, which no closed form covers.
    others = [Ball(id=str(y), position=(1.0, y)) for y in (-0.03, 0.03)]
    tied = scene().model_copy(update={"balls": (*scene().balls, *others)})
    assert not has_closed_form(tied)
    with pytest.raises(GhostballError, match=message):
        run_suite([tied], ["fake"], tmp_path / "out", criteria={"roll": criteria})
    assert not (tmp_path / "out").exists()


def test_scenes_of_one_name_jobs_below_one_and_a_foreign_folder_are_refused(tmp_path: Path) -> None:
    with pytest.raises(GhostballError, match="each scene must be given once, got roll"):
        run_suite([scene(), scene()], ["fake"], tmp_path / "out")
    with pytest.raises(GhostballError, match="`jobs` must be at least 1, got 0"):
        run_suite([scene()], ["fake"], tmp_path / "out", jobs=0)
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(ResultsError, match="not empty"):
        run_suite([scene()], ["fake:does=raise"], tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_an_engine_that_is_absent_needs_no_settings_for_its_criteria(tmp_path: Path) -> None:
    outcome = run_suite([scene()], ["absent"], tmp_path, criteria={"roll": limits("absent:dt=1")})
    assert outcome.cases[0].outcome == "unavailable"


# --- which criteria a scene has


def test_scenes_given_by_path_bring_the_criteria_beside_them(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    scene("by-path").save(path)
    (tmp_path / "mine.expect.toml").write_text('truth = "engine"\n')
    found = criteria_beside_paths(["smoke", "stop", str(path)])
    assert found == {"by-path": Criteria(truth="engine")}
    bare = path.rename(tmp_path / "mine")  # any file that `select` takes for a scene
    assert criteria_beside_paths([str(bare)]) == found


# --- interrupts


@pytest.mark.parametrize("does", ["interrupt", "hand back"])
def test_an_interrupted_run_keeps_what_is_done(tmp_path: Path, does: str) -> None:
    outcome = run_suite([scene()], ["fake", f"fake:does={does}", "ghostball"], tmp_path)
    assert outcome.interrupted
    assert outcome.exit_status == 130
    assert outcome.planned == 3
    folder = Results.open(tmp_path)
    assert [case.label for case in folder.cases] == ["fake"]
    assert folder.motion(folder.cases[0]) is not None
    assert folder.state == "interrupted"


# --- several processes


def test_processes_find_what_one_process_finds(tmp_path: Path) -> None:
    scenes = [scene("one"), scene("two")]
    engines = ["ghostball", "fake:shift=0.25", "fake:does=lose time", "fake:does=exit"]
    run_suite(scenes, engines, tmp_path / "alone")
    run_suite(scenes, engines, tmp_path / "two", jobs=2)
    alone, two = Results.open(tmp_path / "alone"), Results.open(tmp_path / "two")
    assert two.scene_names == alone.scene_names
    assert two.labels == alone.labels
    for case in alone.cases:
        other = two.case(case.scene, case.label)
        assert other is not None
        left = {name: value for name, value in case.metrics.items() if name != "wall_time"}
        right = {name: value for name, value in other.metrics.items() if name != "wall_time"}
        assert left == right
        assert (case.outcome, case.reason) == (other.outcome, other.reason)
        assert np.array_equal(case.rest_positions, other.rest_positions)
    assert multiprocessing.active_children() == []


def group_is_gone(group: int, within: float) -> bool:
    """Whether no process of a group is left, given some time for init to bury the dead."""
    deadline = time.monotonic() + within
    while time.monotonic() < deadline:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False


# That workers are deaf to it is asserted in test_pool.py, and what a run keeps, above.
@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="signals to a process group are POSIX")
@pytest.mark.parametrize("jobs", [1, 2])
def test_ctrl_c_in_a_terminal(tmp_path: Path, fake_engines: Path, jobs: int) -> None:
    # A terminal signals the whole process group: workers must not answer it themselves.
    script = tmp_path / "script.py"
    script.write_text(
        textwrap.dedent(f"""
        from pathlib import Path
        from ghostball.model import Ball, Scene
        from ghostball.validation import run_suite

        if __name__ == "__main__":
            ball = Ball(id="cue", position=(0.0, 0.0), velocity=(1.0, 0.0))
            outcome = run_suite(
                [Scene(name="roll", balls=[ball])],
                ["fake", "fake:does=hang", "fake:shift=1.0", "fake:does=hang,shift=1.0"],
                Path({str(tmp_path / "out")!r}),
                jobs={jobs},
                progress=lambda done, total, record: print("done", done, flush=True),
            )
            raise SystemExit(outcome.exit_status)
        """)
    )
    process = subprocess.Popen(
        [sys.executable, str(script)],
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(fake_engines), *sys.path])},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        assert process.stdout is not None
        for _ in range(jobs):  # one process gets to the first that hangs, two get one further
            assert process.stdout.readline().startswith("done")
        os.killpg(process.pid, signal.SIGINT)
        _, errors = process.communicate(timeout=60)
    finally:
        process.kill()
        process.communicate()
    assert errors == ""  # no traceback of any process
    assert process.returncode == 130
    folder = Results.open(tmp_path / "out")
    assert folder.state == "interrupted"
    assert len(folder.cases) == jobs
    assert group_is_gone(process.pid, within=10.0)


def test_with_a_limit_of_time_a_crash_and_a_hang_cost_one_case_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # With one job, too: breaks where that runs engines in this very process. The hanging one has a
    # limit of its own: that of the others must do for a busy machine.
    def limit_of(seconds: float | None) -> Callable[[Case], float]:
        assert seconds == 300.0
        return lambda case: 0.5 if "hang" in case.label else seconds

    monkeypatch.setattr("ghostball.validation.parallel.pool.limit_of", limit_of)
    engines = ["fake:does=die", "fake:does=hang", "fake"]
    outcome = run_suite([scene()], engines, tmp_path, time_limit=300.0)
    cases = by_label(Results.open(tmp_path).cases)
    assert "exit code 7" in cases["fake:does=die"].reason
    assert "longer than 0.5 s" in cases["fake:does=hang"].reason
    assert cases["fake"].outcome == "ran"
    assert outcome.exit_status == 1
    assert multiprocessing.active_children() == []
