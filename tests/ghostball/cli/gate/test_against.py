"""`ghostball regress --against`: another revision instead of baselines."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest
from commands import cli, edit_engine, refused


@pytest.mark.slow
def test_an_engine_of_ones_own_is_compared_with_another_revision(project):
    def git(*arguments):
        who = ("-c", "user.name=a", "-c", "user.email=a@b")
        subprocess.run(["git", *who, *arguments], check=True, capture_output=True)

    def against(revision="HEAD"):
        # Run in a shell, because both runs are separate commands that write to its stderr.
        words = ["regress", "stop", "--against", revision, "--jobs", "1"]
        command = [sys.executable, "-m", "ghostball", *words]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    git("init")
    assert refused(
        cli("regress", "stop", "--against", "HEAD"), "needs a git repository with the engine's"
    )
    git("add", "my_engine.py")
    git("commit", "-m", "one")
    assert refused(
        cli("regress", "stop", "--against", "none-such"), "`--against` must name a commit"
    )
    same = against()
    assert same.returncode == 0, same.stderr
    assert "1 of 1 case unchanged" in same.stdout
    ratio = re.search(r"run time, .*: median ([\d.]+) in 1 shot", same.stdout)
    assert 0.1 < float(ratio[1]) < 10.0
    edit_engine("x, t = x + step * v", "x, t = x + 1.5 * step * v")
    found = against()
    assert found.returncode == 1, found.stdout + found.stderr
    assert re.search(r"stop +my_engine:simulate +", found.stdout)
    worktrees = subprocess.check_output(["git", "worktree", "list"], text=True)
    assert worktrees.count("\n") == 1, "a worktree was left"
