"""Ten engines that are wrong in ten ways: every command says the same of each, and none passes it.

Each command is run as a user would, on one shot of two balls. A run that is asked the same is held
to the same limits on the same metrics, and the command ends with the same status.
"""

import json
import re
from pathlib import Path

import pytest
from _pytest.pytester import SysModulesSnapshot
from typer.testing import CliRunner
from wrong_engines import WAYS, Wrong

from ghostball.cli import app
from ghostball.model import SampledTrajectory
from ghostball.model.cache_folder import cache_folder
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.stress import StressFolder

pytest_plugins = ["pytester"]

SCENE = "restitution-cut"
IN_ANOTHER_PROCESS = ("crash", "hang")
"""Ways that need a process of their own."""

FAST_WAY = "energy"
IN_THIS_PROCESS = [
    pytest.param(way, marks=[] if way == FAST_WAY else pytest.mark.slow)
    for way in WAYS
    if way not in IN_ANOTHER_PROCESS
]
CACHES = str(cache_folder("kernels").parent)

Said = dict[str, tuple[int, frozenset[str]]]
"""By command: its status, and the limits that it says are broken."""


@pytest.fixture
def here(pytester, monkeypatch):
    """A scratch project, whose home has no kernels."""
    monkeypatch.setenv("GHOSTBALL_CACHE_DIR", CACHES)
    monkeypatch.setenv("COLUMNS", "400")
    # What pytest within pytest loaded stays: neither numpy nor numba's kernels come twice.
    monkeypatch.setattr(SysModulesSnapshot, "restore", lambda _: None)
    return pytester


def label(way: str) -> str:
    return f"wrong_engines:Wrong:way={way}"


def broken_in(text: str) -> frozenset[str]:
    """Return the limits that a text says are broken, as "METRIC <= LIMIT"."""
    return frozenset(
        " ".join(found)
        for found in re.findall(
            r"\b(\w+) must be (==|<=|>=) ([\w.-]+(?: shot)?)(?: \w+)?, (?:got|but)", text
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
        f"ghostball::{SCENE}",
        f"--ghostball-engine={label(way)}",
        *options,
    )
    return int(done.ret), broken_in(done.stdout.str())


def written_elsewhere(way: str, **said: object) -> None:
    """Write the same run as another program would; some of it says something else."""
    scene = find_scene(SCENE)
    result = Wrong(Wrong.Settings(way=way)).simulate(scene, record="trajectory")
    motion = result.trajectory
    assert isinstance(motion, SampledTrajectory)
    run_elsewhere = result.to_dict() | {
        "resolution": 0.0,
        "samples": {
            "t": motion.times.tolist(),
            "positions": motion.positions.tolist(),
            "velocities": motion.velocities.tolist(),
            "angular_velocities": motion.angular_velocities.tolist(),
        },
    }
    Path("run.json").write_text(json.dumps(run_elsewhere | said), encoding="utf-8")


def by_grade(way: str, **said: object) -> tuple[int, frozenset[str]]:
    written_elsewhere(way, **said)
    return judged("grade", "run.json")


def by_stress(way: str) -> tuple[int, frozenset[str]]:
    """Try the shot; what is printed is the first fault alone, and all are in the folder."""
    trial = (f"shipped/{SCENE}", "--full", "--out", "stress")
    status, _ = run("stress", *trial, "-e", label(way))
    found = StressFolder.load(Path("stress")).findings
    return status, broken_in("\n".join(fault for one in found for fault in one.faults))


def by_leaderboard(way: str, *options: object) -> tuple[int, frozenset[str]]:
    """Play shots of the board; what it says is in its folder, in the suite's records."""
    columns = ("--column", "cut", "--column", "mm")
    engine = ("--only", "-e", label(way))
    status, _ = run("leaderboard", *engine, *columns, "--out", "board", *options)
    cases = Results.open(Path("board")).cases
    failed = [check.sentence for case in cases for check in case.checks if check.passed is False]
    return status, broken_in("\n".join(failed))


@pytest.mark.usefixtures("in_this_process")
@pytest.mark.parametrize("way", IN_THIS_PROCESS)
def test_a_wrong_engine_is_the_same_to_every_command(here, way):
    engine = ("-e", label(way))
    said: Said = {
        "validate": judged("validate", SCENE, *engine, "--no-report"),
        "regress": judged("regress", SCENE, *engine),
        "accept": judged("accept", *engine, "--reason", "It is wrong."),
        "stress": by_stress(way),
        "pytest": by_pytest(here, way, "--ghostball-time-limit=inf"),
        "grade": by_grade(way),
    }
    assert {command: status for command, (status, _) in said.items()} == dict.fromkeys(said, 1)
    limits = said["validate"][1]
    assert limits
    if way == "nondeterministic":  # of two plays, no more is the same than that both are wrong
        limits = frozenset({"accuracy <= nanometres"})
        said = {command: (status, found & limits) for command, (status, found) in said.items()}
        said["accept"] = said["regress"] = (1, limits)  # they say that it is another one each time
    assert {command: found for command, (_, found) in said.items()} == dict.fromkeys(said, limits)
    # Nothing was accepted; and who insists has it in the changelog, and fails all the same.
    assert not list(Path("baselines").glob("**/*.toml"))
    status, found = by_leaderboard(way)  # another shot, so that other limits break as well
    assert status == 1
    assert found
    assert {limit.partition(" ")[2] for limit in found & limits} <= {
        limit.partition(" ")[2] for limit in limits
    }


@pytest.mark.usefixtures("in_this_process")
def test_the_right_one_passes_with_every_command(here):
    engine = ("-e", label("right"))
    said = {
        "validate": run("validate", SCENE, *engine, "--no-report"),
        "regress": run("regress", SCENE, *engine),
        "accept": run("accept", *engine, "--reason", "It is right."),
        "regress again": run("regress", SCENE, *engine),
        "stress": run("stress", f"shipped/{SCENE}", "--full", *engine, "--out", "stress"),
        "pytest": by_pytest(here, "right", "--ghostball-time-limit=inf"),
        "grade": by_grade("right"),
        "leaderboard": by_leaderboard("right"),
    }
    statuses = {command: status for command, (status, _) in said.items()}
    assert statuses == dict.fromkeys(said, 0) | {"regress": 4}, said  # nothing accepted yet


@pytest.mark.usefixtures("in_this_process")
def test_an_engine_that_says_nothing_of_how_exact_it_is_passes_nowhere(here):
    # Breaks where an engine that moves nothing is called passed, for nothing limits its shots.
    asked = ("-e", "silent_engine:lazy")
    unjudged = "no shot of silent_engine:lazy was judged by how it ends: give it `dt`"
    status, said = run("validate", SCENE, *asked, "--no-report")
    assert (status, said.strip().splitlines()[-1].startswith(unjudged)) == (4, True), said
    status, said = run("validate", SCENE, *asked, "-e", label("right"), "--no-report")
    assert (status, unjudged in said) == (4, True), said
    assert "No outcome judged" in run("report", "out", "--format=markdown")[1]
    assert f'"{unjudged}' in run("report", "out", "--format=junit")[1]
    board = ("--only", *asked, "--column", "mm", "--out", "board")
    status, said = run("leaderboard", *board)
    assert (status, unjudged in said) == (4, True), said
    run("regress", SCENE, *asked)
    assert run("accept", *asked, "--reason", "It moves nothing.")[0] == 0
    status, said = run("regress", SCENE, *asked)  # what moved is judged, and what isn't is said
    assert (status, unjudged in said) == (0, True), said
    status, said = run("regress", SCENE, *asked, "--fail-on=limits")
    assert (status, unjudged in said) == (4, True), said
    options = ("-pno:cacheprovider", "-pno:hypothesispytest", "--ghostball-time-limit=inf")
    engine = "--ghostball-engine=silent_engine:lazy"
    done = here.runpytest_inprocess(*options, f"ghostball::{SCENE}", engine)
    assert (int(done.ret), unjudged in done.stdout.str()) == (4, True)
    # One that states its step is held to it.
    status, said = run("validate", SCENE, "-e", "silent_engine:stepping", "--no-report")
    assert (status, "was judged" in said) == (1, False), said


@pytest.mark.usefixtures("in_this_process")
def test_who_insists_on_a_wrong_engine_keeps_the_reason_and_fails_all_the_same(here):
    engine = ("-e", label("friction"))
    run("regress", SCENE, *engine)
    insists = ("--reason", "The cloth is new.", "--even-though-limits-fail")
    status, said = run("accept", *engine, *insists)
    assert status == 0, said
    assert "limits of truth are broken" in said
    (changes,) = Path("baselines").glob("**/CHANGES.md")
    assert "The cloth is new." in changes.read_text(encoding="utf-8")
    assert judged("regress", SCENE, *engine) == judged("validate", SCENE, *engine, "--no-report")


LEFT_BEHIND = {
    "no file": None,
    "an empty file": "",
    "a file that is cut off": '{"engine": "wrong", "scene": "restitution-cut", "status": "re',
    "a run without its end": '{"engine": "wrong", "scene": "restitution-cut", "status": "rest"}',
    "a run that says that it failed": {"status": "failed", "reason": "out of memory"},
    "no motion": {"samples": None},
    "less than a ball": {"rest_positions": []},
}
"""What an engine in another language may leave that crashed or was ended, by what that is."""


@pytest.mark.slow
@pytest.mark.parametrize("way", IN_ANOTHER_PROCESS)
def test_an_engine_that_crashes_or_hangs_did_not_finish_whatever_the_command(here, way):
    limit = ("--time-limit", "3" if way == "hang" else "120")
    engine = ("-e", label(way))
    stress = (f"shipped/{SCENE}", "--full", "--out", "stress")
    said = {
        "validate": run("validate", SCENE, *engine, "--no-report", *limit),
        "regress": run("regress", SCENE, *engine, *limit),
        "accept": run("accept", *engine, "--reason", "It is wrong."),
        "stress": run("stress", *stress, *engine, *limit),
        "leaderboard": run("leaderboard", "--only", *engine, "--column", "cut", *limit),
    }
    why = "it took longer than 3 s" if way == "hang" else "exit code 7"
    assert [command for command, (_, text) in said.items() if why not in text] == []
    found: Said = {command: (status, broken_in(text)) for command, (status, text) in said.items()}
    found["pytest"] = by_pytest(here, way, f"--ghostball-time-limit={limit[1]}")
    found["grade"] = by_grade("right", status="failed", reason=why)
    assert found == dict.fromkeys(found, (1, frozenset()))
    assert not list(Path("baselines").glob("**/*.toml"))


@pytest.mark.parametrize("left", LEFT_BEHIND)
def test_what_is_left_of_a_run_is_graded_as_one_that_did_not_finish(here, left):
    found = LEFT_BEHIND[left]
    if isinstance(found, dict):
        written_elsewhere("right", **found)
    elif found is not None:
        Path("run.json").write_text(found, encoding="utf-8")
    status, text = run("grade", "run.json")
    assert (status, broken_in(text)) == (1, frozenset()), text
    assert "did not finish" in text
    # What was played whole is judged all the same.
    Path("run.json").rename("lost.json") if found is not None else None
    written_elsewhere("energy")
    status, text = run("grade", "lost.json", "run.json")
    assert status == 1
    assert "did not finish" in text
    assert broken_in(text)
