"""Commands with a faulty engine: the message names the engine, and the exit status is right."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from xml.etree import ElementTree

import pytest
from commands import cli as run
from faulty_engine import planted

from ghostball.model import Scene

SHOT = """
schema = 1
name = "shot"
title = "</script><script>alert('\\u001b[31mred\\u001b[0m')</script>"
[table]
length = 2.0
width = 1.0
[[balls]]
id = "<svg onload=alert(1)>"
position = [0.5, 0.5]
velocity = [0.5, 0.0]
"""


@pytest.fixture
def faulty(tmp_path, monkeypatch):
    """Install the faulty engine, and work in an empty folder with a scene file."""
    monkeypatch.setenv("COLUMNS", "400")
    monkeypatch.syspath_prepend(str(planted(tmp_path / "site")))
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    (tmp_path / "here" / "shot.toml").write_text(SHOT)
    assert Scene.load("shot.toml").title.startswith("</script>")
    return tmp_path / "here"


COMMANDS = {
    "run": ("run", "stop", "--engine"),
    "explain": ("explain", "stop", "--no-attribute", "--engine"),
    "validate": ("validate", "stop", "--no-report", "--engine"),
}

EXCUSED = "pymunk:config=naive"


MOTIONS = {
    "lose-motion": "`trajectory.sample` raised RuntimeError: lost the motion",
    "cut-motion": "`trajectory.sample` must return positions as floats of shape (",
}


@pytest.mark.usefixtures("faulty", "in_this_process")
@pytest.mark.parametrize("does", MOTIONS)
def test_a_motion_that_cannot_be_sampled_is_the_engines_failure_of_that_case_alone(does):
    # The motion is sampled long after the return of `simulate`, when metrics are computed.
    result = run(*COMMANDS["validate"], f"faulty:does={does}", "-e", "ghostball")
    assert result.exit_code == 1, result.output
    assert f"did not finish stop on faulty:does={does}: {MOTIONS[does]}" in result.output
    assert "ghostball itself failed" not in result.output
    assert re.search(r"\b[1-9]\d* checks passed, 0 failed, 1 case did not finish", result.output)


def test_output_of_an_engine_never_reaches_the_terminal_or_the_json(faulty):
    path = os.pathsep.join(filter(None, sys.path))
    done = subprocess.run(
        [sys.executable, "-m", "ghostball", *COMMANDS["run"], "faulty:does=print", "--format=json"],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    assert json.loads(done.stdout)["engine"] == "faulty"
    assert done.stdout.count("\n") == 1
    assert sorted(done.stderr.splitlines()) == [
        "engine faulty printed: \\x1b[31mfrom Python",
        "engine faulty printed: \\x1b]0;straight to descriptor 1\\x07",
        "engine faulty printed: straight to descriptor 2",
    ]


@pytest.mark.usefixtures("in_this_process", "without_run_figures")
def test_output_of_an_engine_is_in_the_report_and_shown_once(faulty):
    engines = ("-e", "ghostball", "-e", "faulty:does=print")
    result = run("validate", "stop", "half-ball-cut", *engines, "--format=junit")
    assert "engine faulty:does=print printed: \\x1b[31mfrom Python" in result.stderr
    assert "printed this in scene stop, and in 1 more case" in result.stderr
    assert result.stderr.count("from Python") == 1
    text = (faulty / "out" / "report.html").read_text()
    assert "printed: \\x1b[31mfrom Python" in text
    for shown in (text, result.stdout):
        assert "\x1b" not in shown
    assert "\\x1b[31mfrom Python" in result.stdout


@pytest.mark.usefixtures("in_this_process", "without_run_figures")
def test_a_run_in_which_nothing_was_judged_is_no_pass_and_says_what_to_do(faulty):
    # CI must not be green if no limit applies, and all readers of the results must agree.
    result = run("validate", "shot.toml", "-e", EXCUSED, "--format=junit")
    assert result.exit_code == 4, result.output
    assert "nothing was judged: no limit applies." in result.stderr
    assert "Add a limit to shot.expect.toml beside the scene" in result.stderr
    suites = ElementTree.fromstring(result.stdout.encode())
    assert suites.get("errors") == "1"
    assert "nothing was judged" in suites.find("testsuite[@name='ghostball']/testcase/error").get(
        "message"
    )
    assert "Nothing judged" in (faulty / "out" / "report.html").read_text()
    assert "○ Ghostball: Nothing judged" in run("report", "out", "--format=markdown").stdout
    assert (
        "ghostball: error: No limit applies to these cases"
        in run("report", "out", "--format", "text").stdout
    )
    # The limit that the message suggests is read and applied.
    advice = result.stderr.partition("such as:\n")[2].splitlines()[:5]
    (faulty / "shot.expect.toml").write_text("\n".join(advice))
    judged = run("validate", "shot.toml", "-e", EXCUSED, "--no-report")
    assert judged.exit_code == 0, judged.output
    assert "1 checks passed" in judged.stdout


@pytest.mark.usefixtures("faulty", "in_this_process")
def test_why_nothing_was_judged_is_said_of_each_case():
    def advice(*arguments):
        result = run("validate", *arguments, "--no-report")
        assert result.exit_code == 4, result.output
        return result.stderr

    assert f"`{EXCUSED}` is excused from the common limits" in advice("stop", "-e", EXCUSED)
    assert "supports these scenes" in advice("draw-shot", "-e", "paper-discrete")
    everything = advice("stop", "-e", "ghostball", "--metric", "wall_time")
    assert "--metric leaves out every limit" in everything


@pytest.mark.usefixtures("in_this_process", "without_run_figures")
def test_titles_ids_and_reasons_are_no_markup_and_no_escapes_in_a_report(faulty):
    result = run("validate", "shot.toml", "-e", "ghostball", "-e", "faulty:does=garbage")
    assert result.exit_code == 1
    text = (faulty / "out" / "report.html").read_text()
    assert "alert(" in text
    for forbidden in ("<script>alert", "</script><", "<svg onload", "\x1b", "\0"):
        assert forbidden not in text
    for form in ("markdown", "text"):
        printed = run("report", "out", "--format", form).stdout
        assert "in red" in printed
        assert "\0" not in printed
