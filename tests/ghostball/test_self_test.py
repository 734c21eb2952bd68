"""`ghostball stress --self-test`: what it prints, and its exit status."""

from __future__ import annotations

import json
from typing import Any

import pytest
from typer.testing import CliRunner

import ghostball._self_test
from ghostball.cli import app
from validation.stress.self_test import UNCHANGED, Found, SelfTest

CLEAN = Found(UNCHANGED, "", "", (), 9, 1.0)
KILLED = Found("leak", "It leaks.", "graded/stop", ("wrong by 1",), 3, 1.5)
ALIVE = Found("odd", "It is odd.", "", (), 9, 2.0)


def outcome(monkeypatch: pytest.MonkeyPatch, found: SelfTest) -> list[dict[str, Any]]:
    asked: list[dict[str, Any]] = []

    def fake(**options: Any) -> SelfTest:
        asked.append(options)
        options["progress"](KILLED, 1, 3)
        return found

    monkeypatch.setattr(ghostball._self_test, "self_test", fake)
    return asked


def test_all_killed_passes_and_json_has_everything(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = outcome(monkeypatch, SelfTest(1, 9, (KILLED,), CLEAN))
    run = CliRunner().invoke(app, ["stress", "--self-test", "--json", "graded", "--jobs", "1"])
    assert run.exit_code == 0
    said = json.loads(run.stdout)
    assert (said["killed"], said["planned"], said["trials"]) == (1, 1, 9)
    assert said["mutants"][0]["killed_by"] == "graded/stop"
    assert said["unchanged"]["killed"] is False
    assert asked[0]["only"] == ["graded"]
    assert asked[0]["jobs"] == 1


def test_a_survivor_is_shown_and_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    outcome(monkeypatch, SelfTest(2, 9, (KILLED, ALIVE), CLEAN))
    run = CliRunner().invoke(app, ["stress", "--self-test"])
    assert run.exit_code == 1
    assert "1 of 2 bugs were caught" in run.stdout
    assert "survived all 9 trials" in run.stdout


@pytest.mark.parametrize(
    ("found", "status", "text"),
    [
        (SelfTest(1, 9, (), None, interrupted=True), 130, "wasn't come to"),
        (
            SelfTest(1, 9, (KILLED,), Found(UNCHANGED, "", "a/b", ("off",), 2, 1.0)),
            1,
            "breaks in a/b: off",
        ),
    ],
)
def test_an_interrupt_and_a_broken_engine_are_said(
    monkeypatch: pytest.MonkeyPatch, found: SelfTest, status: int, text: str
) -> None:
    outcome(monkeypatch, found)
    run = CliRunner().invoke(app, ["stress", "--self-test"])
    assert run.exit_code == status
    assert text in run.stdout


@pytest.mark.parametrize("options", [["--engines", "pymunk"], ["--suite", "full"]])
def test_what_it_is_not_about_is_refused(options: list[str]) -> None:
    run = CliRunner().invoke(app, ["stress", "--self-test", *options])
    assert run.exit_code == 2
    assert "leave --engines and --suite out" in run.output
