"""`pytest --ghostball`, run in temporary repositories."""

import inspect
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest
from _pytest.pytester import SysModulesSnapshot
from typer.testing import CliRunner

from ghostball.cli import app
from ghostball.model.cache_folder import cache_folder
from ghostball.validation.baselines import ComparedRun, load_baseline
from ghostball.validation.baselines.baseline import Baseline
from ghostball.validation.examples import stepper

pytest_plugins = ["pytester"]

STEPPER = "--ghostball-engine=ghostball.validation.examples.stepper:Stepper"
CACHES = str(cache_folder("kernels").parent)


@pytest.fixture(autouse=True)
def kernels_are_those_of_all_tests(monkeypatch):
    """Share compiled kernels: a temporary repository has its own home, without kernels."""
    monkeypatch.setenv("GHOSTBALL_CACHE_DIR", CACHES)


@pytest.fixture(autouse=True)
def what_is_loaded_stays(monkeypatch):
    """Let the inner pytest unload only the modules of the temporary repository.

    numpy, and the modules that numba loads with its first kernel, can't be loaded twice: later
    tests would get second classes of the same names.
    """
    monkeypatch.setattr(SysModulesSnapshot, "restore", lambda _: drop_scratch_engine())
    yield
    drop_scratch_engine()


def drop_scratch_engine() -> None:
    for name in ("base", "mine"):
        sys.modules.pop(name, None)


def engine(pytester, body: str, *, header: str = "") -> str:
    """Write an engine into the temporary repository; return the option that names it."""
    pytester.syspathinsert()
    source = inspect.getsource(stepper).replace("Stepper", "Mine").replace('"stepper"', '"mine"')
    pytester.makepyfile(
        base=source, mine=f"{header}from base import *\n\n\nclass Mine(Mine):\n{body}"
    )
    drop_scratch_engine()
    return "--ghostball-engine=mine:Mine"


def outcomes(result) -> dict[str, str]:
    """Return the outcome of each test, by its id, from the output of `-v`."""
    lines = re.findall(r"^(\S+) (PASSED|FAILED|SKIPPED)", result.stdout.str(), re.MULTILINE)
    return {name.removeprefix("ghostball::"): outcome for name, outcome in lines}


def run(pytester, *arguments):
    return plain(pytester, "-v", "-rs", *arguments)


def plain(pytester, *arguments):
    # Hypothesis' plugin and a process for the engine would take seconds to load each time. Later
    # options override earlier ones.
    without = ("cacheprovider", "hypothesispytest")
    here = "--ghostball-time-limit=inf"
    return pytester.runpytest_inprocess(*(f"-pno:{name}" for name in without), here, *arguments)


def test_loading_it_loads_nothing_else():
    # Every pytest in the environment loads the plugin.
    code = (
        "import sys, pytest; before = set(sys.modules); import ghostball.pytest_plugin; "
        "print(*sorted(set(sys.modules) - before))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == [
        "ghostball",
        "ghostball.pytest_plugin",
        "ghostball.pytest_plugin.names",
        "lazy_loader",
    ]


def test_without_the_option_there_is_nothing(pytester):
    pytester.makepyfile("def test_own(): pass")
    result = run(pytester, "--ghostball-engine=no-such-engine")  # the option may be in addopts
    result.assert_outcomes(passed=1)
    assert "ghostball" not in outcomes(result)


def test_our_engine_passes_by_its_own_limits(pytester):
    result = run(pytester, "--ghostball", "--ghostball-scenes=half-ball-cut")
    found = outcomes(result)
    assert set(found.values()) == {"PASSED", "SKIPPED"}
    assert found["half-ball-cut::energy_drift"] == "SKIPPED"  # the cloth dissipates energy
    assert found["half-ball-cut::completes"] == found["half-ball-cut::rest_error_ulps"] == "PASSED"
    assert result.ret == 0


def test_a_repository_says_how_far_off_its_engine_may_end(pytester):
    limit = '[[criteria]]\nengines = ["stepper"]\nmetric = "rest_error_max"\nat_most = {}\n'
    pytester.makefile(".toml", limits=limit.format("5e-3") + 'reason = "a step, grown"\n')
    options = (STEPPER, "--ghostball-criteria=limits.toml")
    result = run(pytester, *options, "ghostball::half-ball-cut::rest_error_max")
    result.assert_outcomes(passed=1)
    pytester.makefile(".toml", limits=limit.format("1e-9") + 'reason = "none at all"\n')
    result = run(pytester, *options, "ghostball::half-ball-cut::rest_error_max")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(
        [
            "rest_error_max must be at most 1 nm, got * mm",
            "*reference *closed form",
            "*limit *none at all",
        ]
    )


def test_judged_as_another_engine(pytester):
    result = run(pytester, STEPPER, "--ghostball-as=ghostball", "ghostball::half-ball-cut")
    found = outcomes(result)
    assert found["half-ball-cut::rest_error_ulps"] == "FAILED"
    assert found["half-ball-cut::matching_events"] == "PASSED"
    assert "--ghostball-as ghostball" in result.stdout.str()  # in the command that repeats the test
    result = run(pytester, STEPPER, "--ghostball-as=pymunk", "ghostball::half-ball-cut")
    assert "FAILED" not in outcomes(result).values()


UNRULY = """
    def simulate(self, scene, *, record):
        import os, time
        if scene.name == "stop":
            while True: time.sleep(1.0)
        if scene.name == "head-on":
            os._exit(7)
        os.write(1, b"straight \\x1b[31m to descriptor 1\\n")
        return super().simulate(scene, record=record)
"""


def test_an_engine_that_hangs_or_crashes_fails_that_scene_alone(pytester):
    # The engine must not end pytest.
    option = engine(pytester, UNRULY)
    # Only the hanging engine has a short limit, because all other engines may be slow.
    hangs = run(pytester, option, "ghostball::stop::completes", "--ghostball-time-limit=0.5")
    assert outcomes(hangs) == {"stop::completes": "FAILED"}
    assert "mine failed: it exceeded the time limit of 0.5 s" in hangs.stdout.str()
    picked = [f"ghostball::{name}::completes" for name in ("head-on", "half-ball-cut")]
    result = run(pytester, option, *picked, "--ghostball-time-limit=600", "-rP")
    assert outcomes(result) == {
        "head-on::completes": "FAILED",
        "half-ball-cut::completes": "PASSED",
    }
    text = result.stdout.str()
    assert "mine failed: its process crashed (exit code 7)" in text
    assert "straight \\x1b[31m to descriptor 1" in text  # in its own section
    assert "\x1b[31m" not in text


COUNTING = (
    "    def simulate(self, scene, *, record):\n        with open('runs.txt', 'a') as file: "
    "print(scene.name, file=file)\n        return super().simulate(scene, record=record)\n"
)


def test_collecting_runs_nothing_and_a_scene_runs_once(pytester):
    option = engine(pytester, COUNTING)
    scenes = "--ghostball-scenes=stop,half-ball-cut"
    result = plain(pytester, "--ghostball", option, scenes, "--collect-only", "-q")
    result.stdout.fnmatch_lines(["ghostball::half-ball-cut::completes", "* tests collected in *"])
    assert not Path("runs.txt").exists()
    run(pytester, "--ghostball", option, scenes, "-k", "half-ball-cut and not overlap_max")
    assert Path("runs.txt").read_text(encoding="utf-8").split() == ["half-ball-cut"]


@pytest.mark.slow
def test_a_scene_runs_once_in_several_processes_too(pytester):
    option = engine(pytester, "    def resolution(self, scene): return 0.0\n" + COUNTING)
    pytester.makepyfile(test_own="def test_own(): pass")
    scenes = "--ghostball-scenes=stop,half-ball-cut,head-on"
    result = pytester.runpytest_subprocess("--ghostball", option, scenes, "-n", "2")
    found = result.parseoutcomes()
    assert found["passed"]
    assert found["failed"]
    ran = Path("runs.txt").read_text(encoding="utf-8").split()
    # The smallest scene is simulated with each `record`.
    assert sorted(ran) == ["half-ball-cut", "head-on", "stop", "stop", "stop"]
    result.stdout.fnmatch_lines(["rest position errors in 3 scenes: median * largest * in *"])


def test_every_metric_is_in_the_junit_file(pytester):
    option = engine(pytester, "    def resolution(self, scene): return 0.0\n")
    run(pytester, option, "ghostball::half-ball-cut", "--junitxml=junit.xml", "-x")
    root = ElementTree.parse("junit.xml").getroot()
    cases = {case.get("name"): case for case in root.iter("testcase")}
    assert cases["completes"].get("classname") == "ghostball.half-ball-cut"
    named = {one.get("name"): one.get("value") for one in cases["completes"].iter("property")}
    assert 0.0 < float(named["rest_error_max"]) < 0.01
    failed = [name for name, case in cases.items() if case.find("failure") is not None]
    assert failed == list(cases)[-1:]  # -x


WRONG = {
    "scene": (["--ghostball", "--ghostball-scenes=half-ball-cur"], "Did you mean half-ball-cut"),
    "engine": (["--ghostball", "--ghostball-engine=pymonk"], "Did you mean `pymunk`"),
    "setting": (["--ghostball", "--ghostball-engine=pymunk:dt=fast"], "`dt` of engine `pymunk`"),
    "module": (
        ["--ghostball", "--ghostball-engine=no_such_module:Engine"],
        "engine `no_such_module:Engine` can't be imported: ModuleNotFoundError",
    ),
    "class": (["--ghostball", "--ghostball-engine=pathlib:Path"], "isn't an engine: it lacks"),
    "name of a class": (
        ["--ghostball", STEPPER.replace("Stepper", "Steper")],
        "has no 'Steper'. Did you mean `ghostball.validation.examples.stepper:Stepper`?",
    ),
    "no class": (
        ["--ghostball", "--ghostball-engine=pathlib:Engine"],
        "module `pathlib` has no 'Engine'",
    ),
    "limit of time": (
        ["--ghostball", "--ghostball-time-limit=-1"],
        "`time_limit` must be a positive number of seconds, got -1.0",
    ),
    "other": (["--ghostball", "--ghostball-as=nobody"], "unknown engine 'nobody'"),
    "criteria": (["--ghostball", "--ghostball-criteria=no.toml"], "no.toml: can't read"),
    "picked metric": (["ghostball::stop::rest_error"], "there is no test `ghostball::stop::rest_e"),
    "picked scene": (["ghostball::half-ball-cur"], "Did you mean half-ball-cut"),
    "picked elsewhere": (["ghostball::stop", "--ghostball-scenes=head-on"], "See --ghostball-sce"),
}


@pytest.mark.parametrize(("arguments", "words"), WRONG.values(), ids=WRONG)
def test_wrong_input_is_refused_by_name(pytester, arguments, words):
    result = plain(pytester, *arguments)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert words in result.stderr.str()
    assert "Traceback" not in result.stderr.str() + result.stdout.str()


def test_an_engine_that_cannot_be_made_is_refused_in_one_line(pytester):
    # A missing method of an engine must not be an internal error of pytest.
    option = engine(
        pytester,
        "    pass\n\n\nclass Mine(EngineBase):\n    name, Settings = 'mine', EngineSettings\n",
    )
    result = plain(pytester, "--ghostball", option)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert (
        "engine `mine` can't be made: TypeError: Can't instantiate abstract" in result.stderr.str()
    )


def test_criteria_for_all_scenes_choose_no_truth_and_name_engines_that_there_are(pytester):
    pytester.makefile(".toml", limits='truth = "engine"\n')
    options = ("--ghostball", STEPPER, "--ghostball-criteria=limits.toml")
    assert "`truth` must be left out" in plain(pytester, *options).stderr.str()
    limit = (
        '[[criteria]]\nengines = ["steper"]\nmetric = "overlap_max"\nat_most = 1\nreason = "x"\n'
    )
    pytester.makefile(".toml", limits=limit)
    assert "Did you mean `stepper`" in plain(pytester, *options).stderr.str()


PROJECT = f'[tool.ghostball]\nengines = ["{STEPPER.partition("=")[2]}"]\nscenes = ["stop"]\n'


def test_settings_of_a_project_apply(pytester):
    pytester.makepyprojecttoml(PROJECT)
    found = outcomes(run(pytester, "--ghostball"))
    assert found
    assert "stop::baseline" not in found
    pytester.makepyprojecttoml('[tool.ghostball]\nengines = ["pymunk", "ghostball"]\n')
    result = run(pytester, "--ghostball")
    assert "names several engines: pymunk, ghostball. Choose one" in result.stderr.str()


def test_a_projects_baselines_are_compared_with(pytester):
    pytester.makepyprojecttoml(PROJECT)
    for command in (["regress"], ["accept", "--reason", "The first."]):
        CliRunner().invoke(app, command)
    result = run(pytester, "--ghostball")
    assert outcomes(result)["stop::baseline"] == "PASSED"
    (path,) = pytester.path.glob("baselines/*/stop.json")
    old = load_baseline(path, path.parent.name)
    late = replace(old.record, rest_time=old.record.rest_time + 1.0)
    moved = Baseline.of(ComparedRun(late, old.played.log), old.accepted, old.engine)
    path.write_text(moved.text, "utf-8")
    result = run(pytester, "--ghostball")
    result.stdout.fnmatch_lines(["changed: *the run ended at *", "*ghostball regress stop -*"])
    assert outcomes(result)["stop::baseline"] == "FAILED"


def test_relations_are_tests_on_request(pytester):
    options = ("--ghostball", STEPPER, "--ghostball-scenes=half-ball-cut")
    found = pytester.runpytest_inprocess(*options, "--ghostball-relations=renumber,boost", "-rs")
    found.stdout.fnmatch_lines(["*SKIPPED*a table that moves can't be described*"])
    assert "renumber_factor" not in found.stdout.str()
    found = pytester.runpytest_inprocess(*options, "--ghostball-relations=turn")
    found.stderr.fnmatch_lines(["*must name known relations, got 'turn'*"])
