"""The end of a command, tables in the terminal, and values of options."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import get_args

import pytest
from rich.console import Console
from table_agreements import likeness

from ghostball.cli.measure.verdicts import agreement_table
from ghostball.cli.options import (
    FailOnChoice,
    complete_engine,
    complete_scene,
    processors,
)
from ghostball.cli.shared.tables import facts_table, table_of
from ghostball.cli.shared.terminal import say, stderr
from ghostball.validation.baselines.regression import FailOn
from ghostball.validation.measured.facts import facts_of
from ghostball.validation.measured.figures import ComparedFigure, TableAgreement, families_in
from ghostball.validation.parallel.cluster import ClusterLostError


def run(*words, stdout):
    command = [sys.executable, "-m", "ghostball", *words]
    done = subprocess.run(command, stdout=stdout, stderr=subprocess.PIPE, text=True, check=False)
    return done.returncode, done.stderr


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
@pytest.mark.parametrize("option", ["--format=json", "--record=rest"])
def test_a_full_disk_is_said_in_one_line(option):
    with Path("/dev/full").open("w") as full:
        status, said = run("run", "stop", option, stdout=full)
    assert status == 3
    assert said.startswith("error: standard output: can't be written: No space left")
    assert said.count("\n") == 1


@pytest.mark.skipif(os.name == "nt", reason="pipes that break so are POSIX")
@pytest.mark.parametrize("command", [["scenes"], ["engines"], ["run", "stop", "--format=json"]])
def test_an_output_that_is_closed_early_ends_as_with_other_tools(command):
    # The exit status was once 1, as if a check had failed.
    reads, writes = os.pipe()
    os.close(reads)
    assert run(*command, stdout=writes) == (128 + signal.SIGPIPE, "")
    os.close(writes)


@pytest.mark.parametrize(
    ("raised", "status", "said"),
    [
        (RuntimeError("disc [bold]error"), 3, "ghostball itself failed: RuntimeError: disc [bold]"),
        (
            ClusterLostError("lost the cluster"),
            1,
            "error: lost the cluster\n",
        ),  # no bug
        (KeyboardInterrupt(), 130, "Interrupted."),
    ],
)
def test_each_exception_has_a_status_and_only_a_bug_a_traceback(
    cli, monkeypatch, raised, status, said
):
    def fail(name):
        raise raised

    monkeypatch.setattr("ghostball.cli.measure.run.find_scene", fail)
    result = cli("run", "stop")
    assert (result.exit_code, result.stdout) == (status, "")
    assert said in result.stderr
    assert ("Traceback" in result.stderr) == (status == 3)


def test_no_label_is_read_as_an_emoji(capsys):
    stderr.cache_clear()
    say("my_module:key:dt=1 [bold]:warning:[/]")
    stderr.cache_clear()
    assert capsys.readouterr().err == "my_module:key:dt=1 :warning:\n"


# --- options


def test_what_fails_a_gate_is_asked_for_as_comparisons_know_it():
    assert {choice.value for choice in FailOnChoice} == set(get_args(FailOn))


def test_jobs_are_a_number_or_all_processors(monkeypatch):
    monkeypatch.setattr("ghostball.cli.options.processor_count", lambda: 7)
    assert (processors("auto"), processors("3")) == (7, 3)


def test_the_shell_completes_scenes_tags_and_engines():
    assert complete_scene("half-ball-c") == ["half-ball-cut"]
    assert "smoke" in complete_scene("smo")
    assert complete_engine("pym") == ["pymunk"]


# --- tables


def printed(part, width=80):
    console = Console(width=width)
    with console.capture() as capture:
        console.print(part)
    return capture.get()


def test_numbers_are_set_to_the_right_and_facts_are_no_markup():
    table = table_of(("scene", "balls"), [("stop", "1"), ("break", "16")], right=("balls",))
    lines = [line.rstrip() for line in printed(table).splitlines() if line.strip()]
    assert len({len(line) for line in lines if "─" not in line}) == 1
    assert lines[-1].endswith("16")
    assert "[red]1[/]" in printed(facts_table({"work": "[red]1[/]"}))


@pytest.mark.parametrize(("whole", "kept"), [(None, "first"), (("second",), "second")])
def test_the_first_column_is_whole_unless_others_are_named(whole, kept):
    cells = {"first": "a long name of a scene", "second": "a long name of an engine"}
    table = table_of(tuple(cells), [tuple(cells.values())], whole=whole)
    assert [name for name, text in cells.items() if text in printed(table, 36)] == [kept]


BANKS, REBOUNDS = (
    one for name in ("banks-pool", "cushion-snooker") for one in families_in(facts_of(name))
)
BANK = ComparedFigure(at=1.0, value=2.0, error=0.1, played=2.2)
REBOUND = ComparedFigure(at=1.0, value=0.9, error=None, played=0.8)
BESIDE_TABLES = [
    likeness("ghostball", rebound=1.5, rolling=0.3),
    likeness("my[x]", rebound="it has none", rolling=1.44),
    likeness("lacks all", rebound="no", rolling="no"),
    TableAgreement(
        label="some[engine]",
        families=(
            BANKS.model_copy(update={"figures": (BANK,)}),
            REBOUNDS.model_copy(update={"figures": (REBOUND,)}),
        ),
    ),
]


@pytest.mark.parametrize("found", [BESIDE_TABLES[:3], BESIDE_TABLES[3:]], ids=["graded", "shown"])
def test_engines_beside_real_tables_come_with_how_to_read_them(found, snapshot):
    # Families with and without grades are two tables; an engine without any has no row.
    assert printed(agreement_table(found), 120) == snapshot
