"""Two revisions by turns, in a scratch checkout with planted bugs and interpreted kernels.

Interpreted kernels give the same bits and need no compiling.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from contextlib import nullcontext
from itertools import cycle
from pathlib import Path
from types import SimpleNamespace

import gate
import numpy as np
import pytest

from ghostball import validation
from ghostball.engine import EVENT_DTYPE, GhostballError, simulate
from ghostball.validation.baselines import against as against_module
from ghostball.validation.baselines.against import compare_revisions
from ghostball.validation.baselines.player import NotComparableError, PlayError
from ghostball.validation.baselines.regression import load_regression
from ghostball.validation.results.motions import motion_of_side, save_sides
from ghostball.validation.results.store import Motion

ROOT = Path(validation.__file__).resolve().parent.parent
PACKAGES = ("engine", "reference_adapters", "validation", "reports", "ghostball")
LAW = Path("engine", "impacts", "laws", "cushion_restitution.py")
IDENTITY = {
    f"GIT_{who}_{what}": "tests" for who in ("AUTHOR", "COMMITTER") for what in ("NAME", "EMAIL")
}


def git(root, *arguments):
    done = subprocess.run(
        ["git", "-C", str(root), *arguments],
        env=os.environ | IDENTITY,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


class Checkout:
    """A scratch copy of this code as a repository of its own, with one commit called sound."""

    def __init__(self, place):
        self.place, self.root = place, place / "checkout"
        self.root.mkdir()
        for name in PACKAGES:
            ignored = shutil.ignore_patterns("gallery")
            shutil.copytree(ROOT / name, self.root / name, symlinks=True, ignore=ignored)
        shutil.copy(ROOT / "pyproject.toml", self.root)
        (self.root / ".gitignore").write_text("__pycache__/\n")
        git(self.root, "init", "-q", "-b", "sound")
        git(self.root, "add", "-A")
        git(self.root, "commit", "-q", "-m", "sound")
        for scene in (gate.cut_shot(), gate.roll_shot()):
            scene.save(place / f"{scene.name}.toml")

    def branch(self, name, path, pattern, replacement):
        """Make a branch in which a text of a file is another one."""
        git(self.root, "checkout", "-q", "-b", name, "sound")
        file = self.root / path
        text, count = re.subn(pattern, replacement, file.read_text("utf-8"), count=1)
        assert count == 1, "nothing was planted"
        file.write_text(text, "utf-8")
        git(self.root, "commit", "-q", "-a", "-m", name)
        git(self.root, "checkout", "-q", "sound")

    def regress(
        self, against, out="out", *, head="sound", scenes=("cut.toml", "roll.toml"), times=False
    ):
        """Run the command in the revision `head`; only where asked may it depend on time."""
        git(self.root, "checkout", "-q", head)
        environment = os.environ | {
            "NUMBA_DISABLE_JIT": "1",
            "PYTHONPATH": str(self.root),
            "GHOSTBALL_CACHE_DIR": str(self.place / "cache"),
        }
        return subprocess.run(
            [
                *(sys.executable, "-m", "ghostball", "regress", *scenes),
                *("--against", against, "--out", out, "--format=json"),
                "--times" if times else "--no-times",
            ],
            cwd=self.place,
            env=environment,
            capture_output=True,
            text=True,
            timeout=600,
            check=False,
        )


@pytest.fixture(scope="module")
def checkout(tmp_path_factory):
    found = Checkout(tmp_path_factory.mktemp("against"))
    found.branch("lossy", LAW, r"-laws\.cushion_restitution", "-0.999999")
    found.branch("broken", "engine/__init__.py", r"\Z", "\ndef broken(:\n")
    found.branch(
        "crashing", "engine/shot.py", r"\Z",
        "\n\ndef simulate(*_, **__):\n    import os\n    os._exit(11)\n",
    )  # fmt: skip
    return found


@pytest.mark.slow
def test_a_revision_is_identical_to_itself(checkout):
    done = checkout.regress("HEAD", times=True)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert done.stdout.count("\n") == 1
    assert {one["scene"]: one["change"] for one in found["scenes"]} == {
        "cut": "identical",
        "roll": "identical",
    }
    assert (found["against"], found["outcome"]) == ("HEAD", "passed")
    assert found["base"]["git"] == {
        "revision": git(checkout.root, "rev-parse", "sound"),
        "dirty": False,
    }
    for one in found["scenes"]:
        assert one["time"]["ratio"] > 0.0
        assert motion_of_side(checkout.place / "out", one["scene"], "base") is None


@pytest.mark.slow
def test_a_planted_bug_is_told_from_both_sides_with_the_motion_of_both(checkout):
    done = checkout.regress("sound", "worse", head="lossy")
    assert done.returncode == 1, done.stderr
    found = load_regression(checkout.place / "worse")
    assert json.loads(done.stdout) == json.loads(found.model_dump_json(by_alias=True))
    cut, roll = found.scene("cut"), found.scene("roll")
    assert (cut.change, cut.failed) == ("worse", True)
    assert (roll.change, roll.failed) == ("identical", False)
    assert cut.first_difference.index > 0, "the first event is no cushion's"
    assert cut.first_difference.before_horizon
    for side, rest in (("base", cut.rest_base), ("head", cut.rest_head)):
        motion = motion_of_side(checkout.place / "worse", "cut", side)
        assert motion.positions[-1].tolist() == [list(place) for place in rest]
    assert motion_of_side(checkout.place / "worse", "roll", "base") is None
    # The other way round, what was wrong is right now.
    done = checkout.regress("lossy", "better")
    assert done.returncode == 1, done.stderr
    assert load_regression(checkout.place / "better").scene("cut").change == "better"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("revision", "status", "said"),
    [
        ("none", 2, "`--against` must name a commit"),
        ("broken", 4, "SyntaxError"),
        ("crashing", 4, "exit code 11"),
    ],
)
def test_a_revision_that_cannot_be_compared_with_is_one_error(checkout, revision, status, said):
    done = checkout.regress(revision, f"not-{revision}", scenes=["roll.toml"])
    assert done.returncode == status, done.stderr
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    if status == 4:
        said = json.loads(done.stdout)
        assert (said["outcome"], said["scenes"]) == ("no-baseline", [])
    else:
        assert done.stdout == ""
    assert load_regression(checkout.place / f"not-{revision}") is None


# --- without another process ------------------------------------------------------------------

CUT, ROLL = gate.cut_shot(), gate.roll_shot()


class Plays:
    """Stands for a revision: plays as our engine does, but for what a test plants."""

    def __init__(self, change=lambda result: result, seconds=1.0, refused=()):
        self.change, self.taken, self.refused = change, seconds, refused
        self.asked = []

    def play(self, scene, path):
        if scene.name in self.refused:
            raise PlayError(f"{scene.name}: no such law")
        return self.change(simulate(scene, record="trajectory"))

    def seconds(self, path, runs):
        self.asked.append(path.name)
        return self.taken


@pytest.fixture
def sides(monkeypatch, tmp_path):
    """Return a function that compares two sides that are played in this process."""
    (tmp_path / "out").mkdir()

    def compare(base, head, scenes=(CUT, ROLL), **options):
        waiting = cycle([base, head])
        monkeypatch.setattr(against_module, "repository", lambda source: tmp_path)
        monkeypatch.setattr(against_module, "source_of", lambda label: tmp_path / "engine.py")
        monkeypatch.setattr(against_module, "resolve", lambda revision, root: "a" * 40)
        monkeypatch.setattr(against_module, "worktree", lambda root, commit: nullcontext(root))
        monkeypatch.setattr(against_module, "playing", lambda *_: nullcontext(next(waiting)))
        monkeypatch.setattr(against_module, "shipped_criteria", lambda scene: NO_TRUTH)
        return compare_revisions(scenes, "v1", tmp_path / "out", **options)

    return compare


NO_TRUTH = SimpleNamespace(truth="engine")


def test_slower_beyond_doubt_fails_with_the_same_bits(sides):
    found = sides(Plays(seconds=1.0), Plays(seconds=1.5))
    for one in found.scenes:
        assert one.change == "identical"
        assert one.failed
        assert one.time.slower
        assert one.time.ratio == 1.5
        assert "1.50 times as slow" in one.summary
    assert found.outcome == "failed"


def test_slower_by_no_more_than_two_processes_differ_passes(sides):
    found = sides(Plays(seconds=1.0), Plays(seconds=1.1))
    assert {one.time.ratio for one in found.scenes} == {1.1}
    assert found.outcome == "passed"


def test_times_are_left_out_where_no_round_is_asked_for(sides):
    head = Plays(seconds=9.0)
    found = sides(Plays(), head, rounds=0)
    assert not head.asked
    assert all(one.time is None for one in found.scenes)


def test_what_looks_slower_is_timed_again_and_must_look_so_again(sides):
    class Once(Plays):
        def seconds(self, path, runs):
            super().seconds(path, runs)
            return 9.0 if len(self.asked) <= 5 else 1.0

    head = Once()
    found = sides(Plays(), head, scenes=[CUT], rounds=5)
    assert len(head.asked) == 5, "five rounds leave doubt, so nothing looks slower"
    assert found.outcome == "passed"

    class Twice(Plays):
        def seconds(self, path, runs):
            super().seconds(path, runs)
            return 9.0 if len(self.asked) <= 15 else 1.0

    head = Twice()
    found = sides(Plays(), head, scenes=[CUT], rounds=15)
    assert len(head.asked) == 30
    assert not found.scenes[0].time.slower
    assert found.outcome == "passed"


def test_both_sides_go_first_by_turns(sides):
    order = []

    class Told(Plays):
        def seconds(self, path, runs):
            order.append(self)
            return 1.0

    base, head = Told(), Told()
    sides(base, head, scenes=[CUT], rounds=3)
    assert order == [base, head, head, base, base, head]


def test_a_scene_that_the_revision_refuses_is_not_comparable(sides):
    found = sides(Plays(refused=["cut"]), Plays())
    cut, roll = found.scenes
    assert (cut.change, cut.failed) == ("not-comparable", False)
    assert "no such law" in cut.summary
    assert roll.change == "identical"
    assert found.outcome == "no-baseline"
    with pytest.raises(NotComparableError, match="can play none of these scenes: cut: no such law"):
        sides(Plays(refused=["cut", "roll"]), Plays())


def test_nothing_to_compare_is_no_pass(sides):
    found = sides(Plays(), Plays(), scenes=[])
    assert found.outcome == "no-baseline"


def test_motion_of_an_earlier_comparison_goes(sides, tmp_path):
    out = tmp_path / "out"
    still = np.zeros((1, 1, 3))
    motion = Motion(np.zeros(0, EVENT_DTYPE), np.zeros(1), still, still, still, *np.zeros((3, 1)))
    save_sides(out, {("roll", "base"): motion})
    assert motion_of_side(out, "roll", "base") is not None
    sides(Plays(), Plays(), scenes=[ROLL])
    assert motion_of_side(out, "roll", "base") is None


def test_motion_that_cannot_be_written_is_told(sides, tmp_path):
    (tmp_path / "out").rmdir()
    (tmp_path / "out").write_text("in the way")
    with pytest.raises(GhostballError, match="Choose another `--out`"):
        sides(Plays(), Plays(), scenes=[ROLL])


def test_progress_counts_to_its_end(sides):
    told = []
    sides(Plays(), Plays(), rounds=2, progress=lambda *step: told.append(step))
    assert [done for done, _, _ in told] == list(range(1, 7))
    assert {planned for _, planned, _ in told} == {6}
