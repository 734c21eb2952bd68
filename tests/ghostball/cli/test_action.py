"""The GitHub action: its steps, run like a GitHub runner, in a repository with a changed engine."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
import yaml

from ghostball.cli.action import options_from
from ghostball.cli.options import FAIL_ON_MEANINGS, FailOnChoice
from ghostball.cli.shared.config import ConfigError
from ghostball.model.cache_folder import cache_folder

ROOT = Path(__file__).parents[3]
ACTION = yaml.safe_load((ROOT / "action.yml").read_text(encoding="utf-8"))
STEPS = ACTION["runs"]["steps"]
SCENES = "stop half-ball-cut three-ball-chain"


@dataclass(frozen=True)
class Ended:
    """The results of the action: status of its last step, outputs, summary, log, uploaded files."""

    status: int
    outputs: dict[str, str]
    summary: str
    log: str
    kept: list[Path]

    @property
    def notes(self) -> list[str]:
        return [line for line in self.log.splitlines() if line.startswith("::")]

    def is_judged(self, status: int, verdict: str) -> bool:
        assert (self.status, self.outputs["verdict"]) == (status, verdict), self.log
        return True


PIP_IS_WRITTEN_DOWN = """\
#!/bin/sh
[ "$2" = pip ] && {{ echo "$@"; exit; }}
exec {} "$@"
"""


def restore_libraries(temporary: Path) -> None:
    """Act as the cache step: provide the kernels that an earlier run compiled."""
    restored = temporary / "ghostball" / "libraries"
    if not restored.exists():
        restored.parent.mkdir(parents=True, exist_ok=True)
        restored.symlink_to(cache_folder("libraries"), target_is_directory=True)


def run_action(repository: Path, temporary: Path, **inputs: str) -> Ended:
    """Run the steps of the action in a checkout, like a runner of GitHub."""
    given = {name: str(one.get("default", "")) for name, one in ACTION["inputs"].items()}
    given |= {name.replace("_", "-"): value for name, value in inputs.items()}
    tools = temporary / "tools"
    tools.mkdir(parents=True, exist_ok=True)
    files = {name: temporary / name.lower() for name in ("GITHUB_OUTPUT", "GITHUB_STEP_SUMMARY")}
    for file in files.values():
        file.write_text("", encoding="utf-8")
    (tools / "python").write_text(PIP_IS_WRITTEN_DOWN.format(sys.executable), encoding="utf-8")
    (tools / "python").chmod(0o755)
    contexts = {f"inputs.{name}": value for name, value in given.items()}
    contexts |= {"github.action_path": str(ROOT), "runner.temp": str(temporary), "github.job": "x"}
    contexts |= {"strategy.job-index": "0"}
    restore_libraries(temporary)
    environment = {name: one for name, one in os.environ.items() if not name.startswith("GITHUB_")}
    environment |= {name: str(file) for name, file in files.items()}
    environment |= {"CI": "true", "GITHUB_ACTIONS": "true", "GITHUB_WORKSPACE": str(repository)}
    environment |= {"PATH": f"{tools}{os.pathsep}{os.environ['PATH']}"}
    status, log, kept = 0, "", []

    def filled(text: str) -> str:
        return re.sub(r"\$\{\{ (.*?) \}\}", lambda found: value_of(found[1]), text)

    def value_of(expression: str) -> str:
        name, _, default = expression.partition(" || ")
        return contexts.get(name, "") or default.strip("'")

    for step in STEPS:
        if "run" in step and not status:  # a runner skips steps after a failure
            (temporary / "step.sh").write_text(step["run"], encoding="utf-8")
            ended = subprocess.run(
                ["bash", "--noprofile", "--norc", "-e", "-o", "pipefail", temporary / "step.sh"],
                cwd=repository / filled(step["working-directory"]),
                env=environment | {name: filled(value) for name, value in step["env"].items()},
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                check=False,
            )
            status, log = ended.returncode, log + ended.stdout
            for line in files["GITHUB_OUTPUT"].read_text("utf-8").splitlines():
                name, _, value = line.partition("=")
                contexts[f"steps.{step.get('id')}.outputs.{name}"] = value
        elif "upload-artifact" in step.get("uses", ""):
            assert step["if"] == "${{ !cancelled() && steps.gate.outputs.results != '' }}"
            if contexts.get("steps.gate.outputs.results"):
                names = filled(step["with"]["path"]).split()
                kept = [path for name in names if (path := repository / name).is_file()]
                assert len(kept) == len(names)
    outputs = {name: filled(one["value"]) for name, one in ACTION["outputs"].items()}
    return Ended(status, outputs, files["GITHUB_STEP_SUMMARY"].read_text("utf-8"), log, kept)


def ghostball(folder: Path, *arguments: str) -> str:
    ended = subprocess.run(
        [sys.executable, "-m", "ghostball", *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    return ended.stdout + ended.stderr


@pytest.fixture(scope="module")
def guarded(tmp_path_factory):
    """A repository with the engine of `init`, its workflow and its baselines."""
    folder = tmp_path_factory.mktemp("project")
    ghostball(folder, "init", "--ci")
    ghostball(folder, "regress", *SCENES.split())
    done = ghostball(folder, "accept", "--reason", "x")
    assert "accepted: stop, half-ball-cut, three-ball-chain" in done
    shutil.rmtree(folder / "out")
    for command in ("init", "add .", "-c user.name=x -c user.email=x@x commit -m x"):
        subprocess.run(["git", *command.split()], cwd=folder, check=True, capture_output=True)
    return folder


@pytest.fixture
def repository(guarded, tmp_path):
    """A clone of the repository, as a runner checks it out."""
    clone = ["git", "clone", "--quiet", str(guarded), str(tmp_path / "checkout")]
    subprocess.run(clone, check=True)
    return tmp_path / "checkout"


EDITS = {
    "better": ("dt: float = 1e-3", "dt: float = 2.5e-4"),
    "worse": ("dt: float = 1e-3", "dt: float = 4e-3"),
    "making energy": ("impulse = 0.5 *", "impulse = 0.525 *"),
    "raising": ("slowing = ", "nothing = {}['cue']\n        slowing = "),
}
"""Changes of the engine, by the class of the resulting change."""


@pytest.mark.slow
class TestInARepository:
    @pytest.fixture
    def act(self, repository, tmp_path):
        """Run the action in the repository with a changed engine."""

        def run(change: str = "", **inputs: str) -> Ended:
            if change:
                path = repository / "my_engine.py"
                text = path.read_text("utf-8")
                assert EDITS[change][0] in text
                path.write_text(text.replace(*EDITS[change]), "utf-8")
            return run_action(repository, tmp_path / "t", **{"scenes": SCENES} | inputs)

        return run

    def test_nothing_changed(self, act):
        ended = act()
        assert ended.status == 0, ended.log
        assert ended.outputs == {"verdict": "passed", "changed": "", "worst": ""}
        assert not ended.notes
        assert "nothing changed in 3 scenes" in ended.summary
        assert [path.name for path in ended.kept] == ["report.html", "results.db"]
        assert f"{ROOT}[compiler]" in ended.log

    def test_a_project_in_a_folder_shadows_no_package_and_its_page_is_kept(self, act, repository):
        # The project's folder must not come first on the path, and `results` must not be relative
        # to it: the upload step runs in the folder of the checkout.
        folder = repository / "sub"
        folder.mkdir()
        for name in ("my_engine.py", "pyproject.toml", "baselines"):
            shutil.move(repository / name, folder / name)
        (folder / "typer.py").write_text("raise ImportError\n", "utf-8")
        ended = act(scenes="stop", working_directory="sub")
        assert ended.is_judged(0, "passed")
        assert ended.kept == [folder / "out" / name for name in ("report.html", "results.db")]

    def test_an_engine_that_gets_better_is_to_be_accepted_or_passes(self, act):
        ended = act("better")
        assert ended.is_judged(1, "failed")
        assert ended.outputs["changed"] == SCENES
        passed = act(fail_on="worse")
        assert passed.is_judged(0, "passed")
        assert {note.partition(" ")[0] for note in passed.notes} == {"::warning"}

    def test_an_engine_that_gets_worse_fails_with_its_scene(self, act):
        ended = act("worse", fail_on="worse")
        assert ended.is_judged(1, "failed")
        assert ended.outputs["worst"] in ended.outputs["changed"].split()
        errors = [note for note in ended.notes if note.startswith("::error")]
        assert sum("title=Ghostball%3A half-ball-cut" in one for one in errors) == 1
        assert "● now" in ended.summary
        assert re.search(r"half-ball-cut +[·━○●]+ +[\d.]+ mm -> [\d.]+ mm", ended.summary)
        assert act(fail_on="limits").is_judged(0, "passed")

    @pytest.mark.parametrize(
        ("change", "title", "said"),
        [("making energy", "fails a limit", ""), ("raising", "did not finish", "KeyError")],
    )
    def test_an_engine_that_gains_energy_or_raises_fails_by_limits(self, act, change, title, said):
        ended = act(change, fail_on="limits")
        assert ended.is_judged(1, "failed")
        (first, *_) = (note for note in ended.notes if title in note)
        assert said in first
        assert ended.kept

    def test_without_baselines_the_action_says_how_to_make_them(self, act, repository):
        shutil.rmtree(repository / "baselines")
        ended = act()
        assert ended.is_judged(4, "not-judged")
        (only,) = ended.notes
        assert only.startswith("::error title=")
        assert "ghostball accept" in only
        # From the uploaded files, baselines can be made on another machine.
        done = ghostball(repository, "accept", "--reason", "x", "--out", str(ended.kept[1].parent))
        assert "accepted: stop, half-ball-cut, three-ball-chain" in done
        assert act(fail_on="limits").is_judged(0, "passed")


@pytest.mark.parametrize(
    ("inputs", "said"),
    [
        ({}, "no engine is named"),
        ({"engine": "mine:Mine", "fail_on": "wors"}, "`fail-on` must be one of changed, worse"),
        ({"engine": "mine:Mine"}, "can't be imported"),
    ],
)
@pytest.mark.slow
def test_bad_input_is_one_error_and_nothing_is_lost(tmp_path, inputs, said):
    folder = tmp_path / "checkout"
    folder.mkdir()
    ended = run_action(folder, tmp_path / "t", **inputs)
    assert ended.status == 2, ended.log
    assert ended.outputs["verdict"] == "error"
    (only,) = ended.notes
    assert said in only
    assert said in ended.summary
    assert not ended.kept
    assert list(folder.iterdir()) == []


def test_inputs_are_words_of_a_shell(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given = {
        "INPUT_ENGINE": " a:B  pymunk:dt=1e-4\n",
        "INPUT_SCENES": "'my scenes/*.toml' smoke",
        "INPUT_FAIL_ON": "worse",
    }
    asked = options_from(given)
    assert asked.engine == ["a:B", "pymunk:dt=1e-4"]
    assert asked.scenes == ["my scenes/*.toml", "smoke"]
    assert (asked.baselines, asked.fail_on) == (None, FailOnChoice.WORSE)
    with pytest.raises(ConfigError, match="no engine is named"):
        options_from({})


def test_the_name_of_the_artifact_is_of_the_use_and_the_job():
    # Two uses in one job, or two jobs of a matrix, must not upload pages with the same name.
    (name,) = (step["with"]["name"] for step in STEPS if "upload" in step.get("uses", ""))
    for one in ("inputs.artifact", "github.job", "strategy.job-index"):
        assert f"${{{{ {one} }}}}" in name
    assert ACTION["inputs"]["artifact"]["default"] == "ghostball"


def test_every_input_is_used_and_none_is_pasted_into_a_command():
    text = (ROOT / "action.yml").read_text(encoding="utf-8")
    for name in ACTION["inputs"]:
        assert f"inputs.{name} " in text, name
    assert not [step["run"] for step in STEPS if "${{" in step.get("run", "")]


def test_the_meanings_of_fail_on_are_the_same_everywhere():
    described = ACTION["inputs"]["fail-on"]["description"]
    page = " ".join((ROOT / "docs/ci.md").read_text(encoding="utf-8").split())
    for name, meaning in FAIL_ON_MEANINGS.items():
        assert f"{name} - {meaning}. " in described
        assert f"`{name}`: {meaning}." in page
