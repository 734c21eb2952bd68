"""`ghostball regress`: compare engines with their baselines, and print the changes."""

from __future__ import annotations

import shlex
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import typer
from rich.console import Console
from rich.markup import escape

from ghostball.cli.gate.against import run_both
from ghostball.cli.gate.commands import RegressOptions
from ghostball.cli.gate.diff import changes_table
from ghostball.cli.shared.config import Config, load_config, named_engines
from ghostball.cli.shared.hints import coverage
from ghostball.cli.shared.report import print_for_programs
from ghostball.cli.shared.running import run_cases
from ghostball.cli.shared.terminal import say, tables
from ghostball.model import Scene
from ghostball.reference_adapters import names_class
from ghostball.reference_adapters.registry import OURS
from ghostball.reports.outcome import kinds_text
from ghostball.reports.words import many
from ghostball.validation.baselines import Gate, Regression, compare_results, save_regressions
from ghostball.validation.baselines.regression import LENIENT, FailOn
from ghostball.validation.checks.verdict import is_unfinished, not_judged
from ghostball.validation.exit_status import ExitStatus, worst
from ghostball.validation.results.records import COMPLETE_STATUSES, CaseRecord
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.gases import many_balls
from ghostball.validation.scenes.library import select
from ghostball.validation.suite.hints import shared
from ghostball.validation.suite.plan import criteria_beside_paths
from ghostball.validation.suite.suite import SuiteResult, run_suite

_VERDICTS = {
    ExitStatus.PASSED: "[green]passed[/]",
    ExitStatus.CHECK_FAILED: "[bold red]failed[/]",
    ExitStatus.HARNESS_FAILED: "[bold red]failed[/]",
    ExitStatus.NOT_JUDGED: "[bold yellow]no baseline[/]",
}


def run(asked: RegressOptions) -> ExitStatus:
    """Run the scenes, compare them with the baselines, and return the exit status.

    Raises `typer.BadParameter` if options contradict each other.
    """
    if asked.against is not None and asked.fail_on is not None:
        raise typer.BadParameter(
            "applies to baselines, but --against compares revisions and fails if an engine is less "
            "accurate by a class. Remove one of the two",
            param_hint="--fail-on",
        )
    started, config = time.perf_counter(), load_config()
    labels = labels_of(asked.engine, config)
    if asked.against is not None:
        return run_both(asked, labels, asked.against)
    place = asked.out or config.out
    policy: FailOn = config.fail_on if asked.fail_on is None else asked.fail_on.value
    names = asked.scenes or config.scenes
    chosen, criteria = select(names), criteria_beside_paths(names)
    if not (asked.engine or config.engines):
        say(
            f"No engine is named: comparing Ghostball's own engine in {len(chosen)} scenes. "
            "`ghostball init` sets up your own"
        )
    gates = [Gate.of(label, asked.baselines or config.baselines) for label in labels]
    ran = {scene.name for scene in chosen}
    whole = not asked.scenes or ran >= {scene.name for scene in select(config.scenes)}
    for gate in gates:
        made = many_balls() if gate.label == OURS and whole else ()
        gate.check([scene.name for scene in (*chosen, *made)])
    outcome = run_cases(
        run_suite,
        chosen,
        labels,
        place,
        asked,
        criteria=criteria,
        only=[(scene.name, label) for scene in chosen for label in labels],
    )
    if outcome.interrupted:
        say("[bold]Interrupted:[/] nothing was compared. Run the same command to continue")
        return ExitStatus.INTERRUPTED
    results = Results.open(place)
    # The folder may hold results of other scenes, from an earlier run.
    only = ran | {scene.name for scene in many_balls()}
    found = [
        compare_results(
            results, gate, whole=whole, only=only, time_limit=asked.time_limit, fail_on=policy
        )
        for gate in gates
    ]
    save_regressions(found, place)
    advice = _accept_command(asked)
    seconds = time.perf_counter() - started
    for regression in found:
        _show(regression, outcome, place, tables(asked.form), seconds, advice)
    print_for_programs(place, asked.form)
    return worst(*(_status(regression, outcome) for regression in found))


def labels_of(engines: Sequence[str] | None, config: Config) -> tuple[str, ...]:
    """Return the engines of the command line, else those of the project, else Ghostball's own."""
    return tuple(dict.fromkeys(named_engines(engines, config) or (OURS,)))


def _accept_command(asked: RegressOptions) -> str:
    """Return the `ghostball accept` command for the results of a run with these options."""
    engines = [("-e", one) for one in asked.engine or ()]
    options = [*engines, ("--out", asked.out), ("--baselines", asked.baselines)]
    words = [str(word) for pair in options if pair[1] is not None for word in pair]
    return shlex.join(["ghostball", "accept", *words]) + ' --reason "..."'


def compare_with_baselines(
    results: Results,
    gates: Sequence[Gate],
    scenes: Sequence[Scene],
    time_limit: float,
    fail_on: FailOn,
) -> list[Regression]:
    """Compare the finished cases that have a baseline, and store the comparisons."""
    found = []
    for gate in gates:
        ended = {
            case.scene
            for case in results.cases
            if case.label == gate.label and case.status in COMPLETE_STATUSES
        }
        if only := {scene.name for scene in scenes if gate.guards(scene.name)} & ended:
            found.append(
                compare_results(
                    results, gate, whole=False, only=only, time_limit=time_limit, fail_on=fail_on
                )
            )
    if found:
        save_regressions(found, results.path)
    return found


def _status(regression: Regression, outcome: SuiteResult) -> ExitStatus:
    compared = {
        "failed": ExitStatus.CHECK_FAILED,
        "no-baseline": ExitStatus.NOT_JUDGED,
        "passed": ExitStatus.PASSED,
    }[regression.outcome]
    # A comparison is a verdict even if no limit applies, except with `--fail-on limits`.
    own = [case for case in outcome.cases if case.label == regression.label]
    limits = ExitStatus(replace(outcome, cases=own).exit_status)
    unlimited = limits is ExitStatus.NOT_JUDGED and regression.fail_on != "limits"
    return worst(compared, ExitStatus.PASSED if unlimited else limits)


def _show(
    regression: Regression,
    outcome: SuiteResult,
    out: Path,
    console: Console,
    seconds: float,
    advice: str,
) -> None:
    new = [one.scene for one in regression.scenes if one.change == "no-baseline"]
    changed = [
        one
        for one in regression.scenes
        if one.failed or one.change not in ("unchanged", "no-baseline")
    ]
    if changed:
        console.print(changes_table(changed))
    if new:
        console.print(f"no baseline: {escape(', '.join(new))}", soft_wrap=True)
    for warning in regression.warnings:
        console.print(f"[yellow]warning:[/] {escape(warning)}", soft_wrap=True)
    own = [case for case in outcome.cases if case.label == regression.label]
    unfinished = sum(map(is_unfinished, own))
    broken = sum(len(case.broken) for case in own)
    of = "" if regression.label == OURS else f" of {escape(regression.label)}"
    asked = regression.fail_on != "limits"
    if new and len(new) == len(regression.scenes) and asked and not (broken or unfinished):
        console.print(
            f"{_VERDICTS[ExitStatus.NOT_JUDGED]} yet for {many(len(new), 'scene')}{of}, which ran "
            f"in {seconds:.0f} s",
            soft_wrap=True,
        )
        say(
            f"To store these results as baselines and detect changes from now on: "
            f"`{escape(advice)}`"
        )
        return
    parts = [kinds_text(regression.scenes).replace("-", " ")] if regression.scenes else []
    if unfinished:
        parts.append(f"{unfinished} did not finish")
    if broken:
        parts.append(f"{many(broken, 'limit')} failed")
    moved = {one.scene for one in regression.moved}
    if said := shared(
        [case for case in own if case.scene in moved],
        [case for case in own if case.scene not in moved and case.outcome == "ran"],
    ):
        console.print(f"Scenes that changed: {escape(said)}", soft_wrap=True)
    for line in _untested(regression.label, own):
        console.print(line, soft_wrap=True)
    if why := not_judged(own):
        console.print(f"[yellow]{escape(why)}[/]", soft_wrap=True)
    verdict = _VERDICTS[_status(regression, outcome)]
    lenient = f"; {LENIENT[regression.fail_on]}" if regression.fail_on in LENIENT else ""
    console.print(
        f"{verdict}: {', '.join(parts) or 'nothing was compared'}, "
        f"compared with the accepted baselines{of}, in {seconds:.0f} s{lenient}",
        soft_wrap=True,
    )
    if changed or new:
        say(f"`ghostball report {escape(str(out))}` shows old and new side by side")
        say_what_next(regression, advice)


def _untested(label: str, own: Sequence[CaseRecord]) -> Iterator[str]:
    """Yield lines about the kinds of shots that these scenes don't test."""
    tries = f"ghostball stress{'' if label == OURS else f' -e {label}'}"
    yield (
        f"[dim]This compared {many(len(own), 'scene')}. `{escape(tries)}` tests grazing balls, "
        "frozen racks, gases and extreme values[/]"
    )
    if names_class(label):
        yield from coverage(own, label)


def say_what_next(regression: Regression, advice: str) -> None:
    """Print how to accept the changes, unless limits failed."""
    if regression.broken:
        names = ", ".join(one.scene for one in regression.broken)
        say(f"Limits failed. Fix the engine instead of accepting these results: {escape(names)}")
    elif any(one.can_be_accepted for one in regression.scenes):
        say(f"If the change is intended: `{escape(advice)}`")
