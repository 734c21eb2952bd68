"""How a command ends: refused, interrupted, failed by a bug of ours or by a full disk."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from ghostball.cli.shared.terminal import say, stderr
from ghostball.validation.parallel.cluster import ClusterLostError


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
@pytest.mark.parametrize("option", ["--format=json", "--record=rest"])
def test_a_full_disk_is_said_in_one_line(option):
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "ghostball", "run", "stop", option],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.returncode == 3
    assert done.stderr.startswith("error: standard output: can't be written: No space left")
    assert done.stderr.count("\n") == 1


@pytest.mark.skipif(os.name == "nt", reason="pipes that break so are POSIX")
@pytest.mark.parametrize("command", [["scenes"], ["engines"], ["run", "stop", "--format=json"]])
def test_an_output_that_is_closed_early_ends_as_with_other_tools(command):
    # It was status 1, as if a check had failed.
    reads, writes = os.pipe()
    os.close(reads)
    done = subprocess.run(
        [sys.executable, "-m", "ghostball", *command],
        stdout=writes,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    os.close(writes)
    assert (done.returncode, done.stderr) == (128 + signal.SIGPIPE, "")


def test_no_label_is_read_as_an_emoji(capsys):
    stderr.cache_clear()
    say("my_module:key:dt=1 [bold]:warning:[/]")
    stderr.cache_clear()
    assert capsys.readouterr().err == "my_module:key:dt=1 :warning:\n"


def test_an_unexpected_error_is_short_with_its_traceback_and_status_3(cli, monkeypatch):
    def fail(name):
        raise RuntimeError("disc [bold]error")

    monkeypatch.setattr("ghostball.cli.measure.run.find_scene", fail)
    result = cli("run", "stop")
    assert result.exit_code == 3
    assert result.stdout == ""
    assert "Traceback" in result.stderr
    assert "ghostball itself failed: RuntimeError: disc [bold]error" in result.stderr


def test_a_cluster_that_is_lost_is_a_run_that_did_not_finish(cli, monkeypatch):
    # It was the status of a bug of Ghostball's.
    def lose(name):
        raise ClusterLostError("lost the cluster")

    monkeypatch.setattr("ghostball.cli.measure.run.find_scene", lose)
    result = cli("run", "stop")
    assert (result.exit_code, result.stderr) == (1, "error: lost the cluster\n")


def test_ctrl_c_in_any_command_is_status_130(cli, monkeypatch):
    def interrupt(name):
        raise KeyboardInterrupt

    monkeypatch.setattr("ghostball.cli.measure.run.find_scene", interrupt)
    result = cli("run", "stop")
    assert result.exit_code == 130
    assert "Interrupted." in result.stderr
