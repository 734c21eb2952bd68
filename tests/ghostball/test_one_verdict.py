"""A table of wrong and right engines: every command gives the same verdict on each.

Each command runs as for a user. All commands apply the same limits to the same metrics, and have
the same exit status: 1 for a wrong engine, 0 for a right one, and 4 for an engine that declares too
little to be judged.
"""

import json
import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import pytest
from _pytest.pytester import SysModulesSnapshot
from typer.testing import CliRunner
from wrong_engines import CRASHES, RIGHT, ROWS, UNJUDGED, WRONG
from wrong_runs import framed, frames_of

from ghostball.cli import app
from ghostball.model import SampledTrajectory
from ghostball.model.cache_folder import cache_folder
from ghostball.reference_adapters import make_engine
from ghostball.reference_adapters.base import resolution_of, stated_error
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.truth.scene_truth import truth_of

pytest_plugins = ["pytester"]

CACHES = str(cache_folder("kernels").parent)

TRUTH_OF = cache(truth_of)
"""References depend on the scene alone: each is computed once for all engines and commands."""

Said = dict[str, tuple[int, frozenset[str]]]
"""Exit status and failed limits, by command."""


@pytest.fixture
def here(pytester, monkeypatch):
    """A temporary project; its home has no kernels."""
    monkeypatch.setenv("GHOSTBALL_CACHE_DIR", CACHES)
    monkeypatch.setenv("COLUMNS", "2000")
    monkeypatch.setattr("ghostball.validation.suite.case.truth_of", TRUTH_OF)
    # Modules loaded by the inner pytest stay loaded: numpy and numba can't be loaded twice.
    monkeypatch.setattr(SysModulesSnapshot, "restore", lambda _: None)
    return pytester


def label(way: str) -> str:
    return ROWS[way].label or f"wrong_engines:Wrong:way={way}"


def broken_in(text: str) -> frozenset[str]:
    """Return the failed limits in a text, as "METRIC at most LIMIT"."""
    return frozenset(
        " ".join(found)
        for found in re.findall(
            r"\b(\w+) must be (exactly|at most|at least) ([\w.+-]+(?: \w+)?), (?:got|but)", text
        )
    )


def run(*arguments: object) -> tuple[int, str]:
    done = CliRunner().invoke(app, [*map(str, arguments)])
    return done.exit_code, done.output


def judged(*arguments: object) -> tuple[int, frozenset[str]]:
    status, text = run(*arguments)
    return status, broken_in(text)


def by_pytest(pytester, way: str, *options: str) -> tuple[int, frozenset[str]]:
    without = ("cacheprovider", "hypothesispytest")
    done = pytester.runpytest_inprocess(
        *(f"-pno:{name}" for name in without),
        *(f"ghostball::{scene}" for scene in ROWS[way].scenes),
        f"--ghostball-engine={label(way)}",
        *options,
    )
    return int(done.ret), broken_in(done.stdout.str())


def run_elsewhere(way: str, scene_name: str) -> dict[str, object]:
    """Return a run in the format of result files, with the claims and the result of the engine."""
    scene, engine = find_scene(scene_name), make_engine(label(way))
    result = engine.simulate(scene, record="trajectory")
    motion = result.trajectory
    if not isinstance(motion, SampledTrajectory):
        motion = frames_of(framed(result))
    stated = resolution_of(engine, scene)
    return result.to_dict() | {
        "engine": "elsewhere",
        "scene": scene.name,
        "resolution": None if stated is None else stated_error(stated),
        "approximate": {
            feature.value: how.how
            for feature, how in engine.capabilities.items()
            if how.support == "approximate"
        },
        "samples": {
            "t": motion.times.tolist(),
            "positions": motion.positions.tolist(),
            "velocities": motion.velocities.tolist(),
            "angular_velocities": motion.angular_velocities.tolist(),
        },
    }


def by_grade(way: str, **said: object) -> tuple[int, frozenset[str]]:
    """Grade a run from a result file, with some fields changed."""
    runs = [run_elsewhere(way, scene) | said for scene in ROWS[way].scenes]
    Path("run.json").write_text(json.dumps(runs), encoding="utf-8")
    return judged("grade", "run.json")


STRESS = (
    "tunnelling/energy-of-bounces",
    "extremes/table-rolling-1e-01",
    "extremes/friction-rolling-10",
    "extremes/speed-sliding-1e04",
    "extremes/mass-ratio-elastic-1e06",
    "extremes/mass-ratio-sliding-1e06",
    "touching/cradle-1-into-2-gap-0",
    "touching/pair-rolling-into-gap-1e-09-turned-0.7",
    "touching/pair-sliding-slanting-gap-1e-09-turned-0.0",
    "long-runs/galperin-1",
)
"""Generated shots in which every fault of the table has an effect."""


def by_stress(way: str, *options: object) -> tuple[int, frozenset[str]]:
    """Run generated shots, which differ from the table's scenes, so other limits fail.

    An engine that can't be judged gets the shots without limits of their own.
    """
    free = [shot for shot in STRESS if shot.startswith("extremes/")]
    shots = free if way in UNJUDGED else STRESS
    status, _ = run("stress", *shots, "--out", "stress", "-e", label(way), *options)
    return status, sentences_in(Path("stress"))


def sentences_in(folder: Path) -> frozenset[str]:
    """Return the failed limits in stored results."""
    cases = Results.open(folder).cases
    failed = [check.sentence for case in cases for check in case.checks if check.passed is False]
    return broken_in("\n".join(failed))


def by_all(pytester, way: str) -> Said:
    """Run every command."""
    scenes, engine = ROWS[way].scenes, ("-e", label(way))
    return {
        "validate": judged("validate", *scenes, *engine, "--no-report"),
        "regress": judged("regress", *scenes, *engine),
        "accept": judged("accept", *engine, "--reason", "The cloth is new."),
        "stress": by_stress(way),
        "pytest": by_pytest(pytester, way, "--ghostball-time-limit=inf"),
        "grade": by_grade(way),
    }


def statuses(said: Mapping[str, tuple[int, object]]) -> dict[str, int]:
    return {command: status for command, (status, _) in said.items()}


REFUSED = {"wrong-counts", "swapped-ends", "moved-ends", "mirrored-ends"}
"""Engines whose results contradict themselves, so that no limit is compared with them."""


@pytest.mark.compiled
@pytest.mark.usefixtures("in_this_process")
@pytest.mark.parametrize("way", WRONG)
def test_a_wrong_engine_fails_with_every_command(here, way):
    said = by_all(here, way)
    assert statuses(said) == dict.fromkeys(said, 1), ROWS[way].fault
    limits = {command: broken for command, (_, broken) in said.items()}
    if way == "nondeterministic":  # two runs agree only in being wrong
        found = {one for one in limits if "accuracy at most nanometres" in limits[one]}
        assert found >= limits.keys() - {"accept", "regress"}
    else:
        by_others = limits.pop("stress")
        assert limits == dict.fromkeys(limits, limits["validate"])
        assert bool(limits["validate"]) == bool(by_others) == (way not in REFUSED)
    assert not list(Path("baselines").glob("**/*.json"))


@pytest.mark.compiled
@pytest.mark.usefixtures("in_this_process")
@pytest.mark.parametrize("way", RIGHT)
def test_a_right_engine_passes_with_every_command(here, way):
    said = by_all(here, way)
    if way == "formula":  # simulates one ball, but claims more
        assert said.pop("stress")[0] == 1
    nothing_accepted = {"regress": 4}
    assert statuses(said) == dict.fromkeys(said, 0) | nothing_accepted, said
    engine = ("-e", label(way))
    status, text = run("regress", *ROWS[way].scenes, *engine)
    assert status == 0, text


@pytest.mark.compiled
@pytest.mark.usefixtures("in_this_process")
@pytest.mark.parametrize("way", UNJUDGED)
def test_an_engine_of_which_nothing_can_be_judged_passes_with_no_command(here, way):
    said = by_all(here, way)
    assert statuses(said) == dict.fromkeys(said, 4), ROWS[way].fault
    assert not list(Path("baselines").glob("**/*.json"))


@pytest.mark.usefixtures("in_this_process")
def test_accepting_a_wrong_engine_stores_the_reason_and_still_fails(here):
    scenes, engine = ROWS["friction"].scenes, ("-e", label("friction"))
    run("regress", *scenes, *engine)
    insists = ("--reason", "The cloth is new.", "--even-though-limits-fail")
    status, said = run("accept", *engine, *insists)
    assert status == 0, said
    assert "accepted, although limits fail:" in said
    (changes,) = Path("baselines").glob("**/CHANGES.md")
    assert "The cloth is new." in changes.read_text(encoding="utf-8")
    assert judged("regress", *scenes, *engine) == judged("validate", *scenes, *engine)


@pytest.mark.usefixtures("in_this_process")
def test_why_nothing_was_judged_is_said_by_every_command(here):
    # A wrong engine must not pass because no limit applies to its shots.
    (scene,), asked = ROWS["braked"].scenes, ("-e", label("braked"))
    unjudged = (
        "no case of silent_engine:braked had its final positions judged: declare a time step `dt`"
    )
    status, said = run("validate", scene, *asked, "--no-report")
    assert (status, said.strip().splitlines()[-1].startswith(unjudged)) == (4, True), said
    status, said = run("validate", scene, *asked, "-e", label("right"), "--no-report")
    assert (status, unjudged in said) == (4, True), said
    assert "Final positions not judged" in run("report", "out", "--format=markdown")[1]
    assert f'"{unjudged}' in run("report", "out", "--format=junit")[1]
    status, said = run("stress", "extremes/table-rolling-1e-01", *asked, "--out", "stress")
    assert (status, unjudged in said) == (4, True), said
    run("regress", scene, *asked)
    status, said = run("accept", *asked, "--reason", "Balls roll half as far.")
    assert (status, unjudged in said) == (4, True), said
    insists = ("--reason", "Balls roll half as far.", "--even-though-limits-fail")
    assert run("accept", *asked, *insists)[0] == 0
    status, said = run("regress", scene, *asked)  # a warning, exit status 0
    assert (status, unjudged in said) == (0, True), said
    status, said = run("regress", scene, *asked, "--fail-on=limits")
    assert (status, unjudged in said) == (4, True), said
    options = ("-pno:cacheprovider", "-pno:hypothesispytest", "--ghostball-time-limit=inf")
    engine = f"--ghostball-engine={label('braked')}"
    done = here.runpytest_inprocess(*options, f"ghostball::{scene}", engine)
    assert (int(done.ret), unjudged in done.stdout.str()) == (4, True)
    # An engine that declares its step is checked with the limits of the step.
    status, said = run("validate", scene, "-e", "silent_engine:stepping", "--no-report")
    assert (status, "was judged" in said) == (1, False), said


LEFT_BEHIND = {
    "no file": None,
    "an empty file": "",
    "a file that is cut off": '{"engine": "wrong", "scene": "half-ball-cut", "status": "re',
    "a run without its end": '{"engine": "wrong", "scene": "half-ball-cut", "status": "rest"}',
    "a run that says that it failed": {"status": "failed", "reason": "out of memory"},
    "no motion": {"samples": None},
    "less than a ball": {"rest_positions": []},
}
"""Files that a crashed or killed engine in another language may leave, by description."""


@pytest.mark.slow
@pytest.mark.parametrize("way", CRASHES)
def test_an_engine_that_crashes_or_hangs_did_not_finish_whatever_the_command(here, way):
    limit = ("--time-limit", "3" if way == "hang" else "120")
    scenes, engine = ROWS[way].scenes, ("-e", label(way))
    said = {
        "validate": run("validate", *scenes, *engine, "--no-report", *limit),
        "regress": run("regress", *scenes, *engine, *limit),
        "accept": run("accept", *engine, "--reason", "It is wrong."),
        "stress": run("stress", STRESS[0], "--out", "stress", *engine, *limit),
    }
    why = "it exceeded the time limit of 3 s" if way == "hang" else "exit code 7"
    assert [command for command, (_, text) in said.items() if why not in text] == []
    found: Said = {command: (status, broken_in(text)) for command, (status, text) in said.items()}
    found["pytest"] = by_pytest(here, way, f"--ghostball-time-limit={limit[1]}")
    found["grade"] = by_grade("right", status="failed", reason=why)
    assert found == dict.fromkeys(found, (1, frozenset()))
    assert not list(Path("baselines").glob("**/*.json"))


@pytest.mark.parametrize("left", LEFT_BEHIND)
def test_incomplete_run_files_did_not_finish(here, left):
    found = LEFT_BEHIND[left]
    whole = run_elsewhere("right", "half-ball-cut")
    if isinstance(found, dict):
        Path("run.json").write_text(json.dumps(whole | found), encoding="utf-8")
    elif found is not None:
        Path("run.json").write_text(found, encoding="utf-8")
    status, text = run("grade", "run.json")
    assert (status, broken_in(text)) == (1, frozenset()), text
    assert "did not finish" in text
    # Complete runs are judged nevertheless.
    Path("run.json").rename("lost.json") if found is not None else None
    other = run_elsewhere("friction", "stop")
    Path("run.json").write_text(json.dumps(other), encoding="utf-8")
    status, text = run("grade", "lost.json", "run.json")
    assert status == 1
    assert "did not finish" in text
    assert broken_in(text)
