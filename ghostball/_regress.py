"""What `ghostball regress` and `accept` do."""

from __future__ import annotations

import shlex
import time
from collections import Counter
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from ghostball._config import Config, load_config
from ghostball._options import Format
from ghostball._progress import COMPILING, Steps
from ghostball._terminal import say, stdout, tables
from ghostball.engine import Scene
from ghostball.reference_adapters import make_engine
from ghostball.reports import summary_markdown
from ghostball.validation.baselines import (
    Acceptance,
    AcceptError,
    LimitsBrokenError,
    NotComparableError,
    NotDeterministicError,
    NothingToAcceptError,
    Regression,
    SceneChange,
    accept,
    can_be_accepted,
    check_baselines,
    compare_results,
    compare_revisions,
    save_regression,
)
from ghostball.validation.baselines.baseline import engine_folder, engine_key
from ghostball.validation.baselines.gate import crowds, with_cases
from ghostball.validation.baselines.junit import regression_xml
from ghostball.validation.baselines.regression import BASELINES, Change, regressions_json
from ghostball.validation.baselines.timing import ROUNDS
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.exit_status import ExitStatus, worst
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.library import select
from ghostball.validation.suite.plan import criteria_beside_paths
from ghostball.validation.suite.suite import Outcome, run_suite
from ghostball.validation.truth.scene_truth import OUR_NAME

_COLOURS: dict[Change, str] = {
    "identical": "green",
    "rounding-only": "yellow",
    "better": "cyan",
    "results-changed": "bold red",
    "worse": "bold red",
    "no-baseline": "yellow",
    "not-comparable": "yellow",
    "not-deterministic": "bold red",
}

_WORDS: dict[Change, str] = {
    "identical": "identical",
    "rounding-only": "rounding only",
    "better": "better against truth",
    "results-changed": "results changed",
    "worse": "worse against truth",
    "no-baseline": "no baseline",
    "not-comparable": "not comparable",
    "not-deterministic": "not deterministic",
}

_VERDICTS = {
    ExitStatus.PASSED: "[green]passed[/]",
    ExitStatus.CHECK_FAILED: "[bold red]failed[/]",
    ExitStatus.HARNESS_FAILED: "[bold red]failed[/]",
    ExitStatus.NOT_JUDGED: "[bold yellow]no baseline[/]",
}


def run(
    wanted: Sequence[str],
    engines: Sequence[str],
    *,
    against: str | None,
    baselines: Path | None,
    out: Path | None,
    form: Format,
    jobs: int,
    rerun: bool,
    time_limit: float,
    timed: bool,
) -> ExitStatus:
    """Compare, print what changed, and return the exit status; see the options of the command.

    Raises
    ------
    GhostballError
        Before anything runs, where the input is wrong or a baseline is nonsense.
    """
    config = load_config()
    names = wanted or config.scenes
    scenes, criteria = select(names), criteria_beside_paths(names)
    gates = _gates(engines, config, baselines, out)
    ran = {scene.name for scene in scenes}
    whole = not wanted or ran >= {scene.name for scene in select(config.scenes)}
    for gate in gates if against is None else ():
        made = crowds() if gate.label == OUR_NAME and whole else ()
        check_baselines(gate.folder, [scene.name for scene in (*scenes, *made)], gate.engine)
    found: list[Regression] = []
    statuses = []
    for gate in gates:
        if len(gates) > 1:
            tables(form).print(f"[bold]{escape(gate.label)}[/]")
        status, regression = _run_one(
            gate,
            scenes,
            criteria,
            against=against,
            whole=whole,
            jobs=jobs,
            rerun=rerun,
            time_limit=time_limit,
            timed=timed,
            form=form,
        )
        if status is ExitStatus.INTERRUPTED:
            return status
        statuses.append(status)
        found.append(regression)
    if form is Format.JSON:
        print(regressions_json(found))
    elif form is Format.JUNIT:
        print(regression_xml(*found), end="")
    elif form is Format.GITHUB:
        for gate, regression in zip(gates, found, strict=True):
            print(summary_markdown(Results.open(gate.out), regression), end="")
    return worst(*statuses)


@dataclass(frozen=True)
class _Gate:
    """An engine that is guarded: as it is asked for, what its baselines call it, its folders."""

    label: str
    engine: str
    folder: Path
    out: Path
    accept: str  # the command that accepts what is found


def _gates(
    engines: Sequence[str], config: Config, baselines: Path | None, out: Path | None
) -> list[_Gate]:
    """Return what is guarded: the engines asked for, else the project's, else ours."""
    labels = tuple(dict.fromkeys(engines or config.engines or (OUR_NAME,)))
    root = config.out / "regress" if out is None else out
    options = [*(("-e", one) for one in engines), ("--out", out), ("--baselines", baselines)]
    words = [str(word) for pair in options if pair[1] is not None for word in pair]
    command = shlex.join(["ghostball", "accept", *words]) + ' --reason "..."'
    gates = []
    for label in labels:
        make_engine(label)
        engine = engine_key(label)
        folder = engine_folder(config.baselines if baselines is None else baselines, engine)
        place = root / folder.name if len(labels) > 1 else root
        gates.append(_Gate(label, engine, folder, place, command))
    return gates


def _run_one(
    gate: _Gate,
    scenes: Sequence[Scene],
    criteria: Mapping[str, Criteria],
    *,
    against: str | None,
    whole: bool,
    jobs: int,
    rerun: bool,
    time_limit: float,
    timed: bool,
    form: Format,
) -> tuple[ExitStatus, Regression]:
    started, out, label = time.perf_counter(), gate.out, gate.label
    nothing = Regression(
        label=label,
        engine=gate.engine,
        against=against or BASELINES,
        base={},
        head={},
        outcome="no-baseline",
        scenes=(),
    )
    steps = Steps(COMPILING, "running", *(("comparing",) if against is not None else ()))
    with steps.bar() as step:
        count = step("running")

        def progress(done: int, planned: int, case: CaseRecord) -> None:
            count(done, planned, case.scene)

        outcome = run_suite(
            scenes,
            [label],
            out,
            jobs=jobs,
            progress=progress,
            compiling=step(COMPILING),
            criteria=criteria,
            reuse=not rerun,
            time_limit=time_limit,
        )
    if outcome.interrupted:
        say("[bold]Interrupted:[/] nothing was compared. The same command goes on from there")
        return ExitStatus.INTERRUPTED, nothing
    results = Results.open(out)
    try:
        if against is not None:
            with steps.bar("comparing") as step:
                regression = compare_revisions(
                    _chosen(scenes, {one.scene for one in outcome.cases if one.outcome == "ran"}),
                    against,
                    out,
                    label,
                    criteria=criteria,
                    rounds=ROUNDS if timed else 0,
                    progress=step("comparing"),
                    time_limit=time_limit,
                )
                regression = with_cases(regression, results)
        else:
            regression = compare_results(
                results, gate.folder, label, whole=whole, time_limit=time_limit
            )
    except NotComparableError as error:
        say(f"[bold red]error:[/] {escape(str(error))}")
        why = nothing.model_copy(update={"warnings": (str(error),)})
        return ExitStatus.NOT_JUDGED, why
    save_regression(regression, out)
    _show(regression, outcome, gate, tables(form), time.perf_counter() - started)
    return _status(regression, outcome), regression


def _chosen(scenes: Sequence[Scene], names: Container[str]) -> list[Scene]:
    return [scene for scene in scenes if scene.name in names]


def _status(regression: Regression, outcome: Outcome) -> ExitStatus:
    compared = {
        "failed": ExitStatus.CHECK_FAILED,
        "no-baseline": ExitStatus.NOT_JUDGED,
        "passed": ExitStatus.PASSED,
    }[regression.outcome]
    # A comparison judges without a limit.
    limits = ExitStatus(outcome.exit_status)
    return worst(compared, ExitStatus.PASSED if limits is ExitStatus.NOT_JUDGED else limits)


def _show(
    regression: Regression, outcome: Outcome, gate: _Gate, console: Console, seconds: float
) -> None:
    new = [one.scene for one in regression.scenes if one.change == "no-baseline"]
    changed = [
        one
        for one in regression.scenes
        if one.failed or one.change not in ("identical", "no-baseline")
    ]
    if changed:
        console.print(_table(changed))
    if new:
        console.print(f"without a baseline: {escape(', '.join(new))}", soft_wrap=True)
    for warning in regression.warnings:
        console.print(f"[yellow]warning:[/] {escape(warning)}", soft_wrap=True)
    counts = Counter(one.change for one in regression.scenes)
    if set(counts) == {"no-baseline"} and not (
        outcome.counts.checks_failed or outcome.counts.unfinished
    ):
        console.print(
            f"{_VERDICTS[ExitStatus.NOT_JUDGED]} yet of {len(new)} scenes, which ran in "
            f"{seconds:.0f} s",
            soft_wrap=True,
        )
        say(f"To keep what they did, and be told what changes: `{escape(gate.accept)}`")
        return
    parts = [f"{counts[name]} {words}" for name, words in _WORDS.items() if counts[name]]
    if outcome.counts.unfinished:
        parts.append(f"{outcome.counts.unfinished} did not finish")
    if outcome.counts.checks_failed:
        parts.append(f"{outcome.counts.checks_failed} limits of truth broken")
    verdict = _VERDICTS[_status(regression, outcome)]
    against = "the accepted baselines" if regression.accepted else f"revision {regression.against}"
    console.print(
        f"{verdict}: {', '.join(parts) or 'nothing was compared'}, "
        f"against {escape(against)}, in {seconds:.0f} s",
        soft_wrap=True,
    )
    if not regression.accepted:
        _show_times(regression, console)
    if changed or new or regression.stale:
        folder = escape(str(gate.out))
        say(f"`ghostball report {folder}` shows it, old and new side by side")
        if regression.accepted:
            _say_what_next(regression, gate)


def _say_what_next(regression: Regression, gate: _Gate) -> None:
    """Say how to accept what moved, where that may be right."""
    if regression.broken:
        names = ", ".join(one.scene for one in regression.broken)
        say(f"Limits of truth are broken, so this is to be mended, not accepted: {escape(names)}")
    elif any(map(can_be_accepted, regression.scenes)) or regression.stale:
        say(f"Where it is right: `{escape(gate.accept)}`")


def _show_times(regression: Regression, console: Console) -> None:
    times = [one.time for one in regression.scenes if one.time is not None]
    ratios = sorted(one.ratio for one in times)
    if ratios:
        middle = ratios[len(ratios) // 2]
        console.print(
            f"run time, head over base: {middle:.3f} in the median of {len(ratios)} scenes, "
            f"{ratios[0]:.3f} to {ratios[-1]:.3f}; slower beyond doubt: "
            f"{sum(one.slower for one in times)}",
            soft_wrap=True,
        )


def _table(changes: Sequence[SceneChange]) -> Table:
    table = Table(box=box.SIMPLE_HEAD)
    table.add_column("scene")
    table.add_column("change", no_wrap=True)
    table.add_column("what moved")
    for one in changes:
        words = _WORDS[one.change]
        if one.change == "identical":
            other = any(not count.within for count in one.counters)
            slower = one.time is not None and one.time.slower
            words = "same bits" + ", other work" * other + ", slower" * slower
        table.add_row(escape(one.scene), f"[{_COLOURS[one.change]}]{words}[/]", escape(one.summary))
    return table


def run_accept(
    engines: Sequence[str],
    reason: str,
    *,
    only: Sequence[str],
    results: Path | None,
    baselines: Path | None,
    even_though_limits_fail: bool,
) -> ExitStatus:
    """Accept, say what was written, and return the exit status.

    Raises
    ------
    GhostballError
        Where there is nothing to accept of any engine.
    """
    gates = _gates(engines, load_config(), baselines, results)
    statuses: list[ExitStatus] = []
    nothing: list[AcceptError] = []
    for gate in gates:
        try:
            done = accept(
                gate.out,
                reason,
                only=only,
                folder=gate.folder,
                engine=gate.engine,
                even_though_limits_fail=even_though_limits_fail,
            )
        except LimitsBrokenError as error:
            say(f"[bold red]error:[/] {escape(str(error))}, or say --even-though-limits-fail")
            statuses.append(ExitStatus.CHECK_FAILED)
        except NotDeterministicError as error:
            say(f"[bold red]error:[/] {escape(str(error))}")
            statuses.append(ExitStatus.CHECK_FAILED)
        except NothingToAcceptError as error:
            nothing.append(error)
        else:
            _say_accepted(done)
            statuses.append(ExitStatus.PASSED)
    if len(nothing) == len(gates):
        raise nothing[0]
    return worst(*statuses)


def _say_accepted(done: Acceptance) -> None:
    for words, names in (("accepted", done.written), ("removed", done.deleted)):
        if names:
            stdout().print(f"{words}: {escape(', '.join(names))}", soft_wrap=True)
    if done.left:
        say(f"moved too, and left as they were: {escape(', '.join(done.left))}")
    for one in done.broken:
        say(
            "[bold yellow]accepted though limits of truth are broken:[/] "
            + escape(f"{one.scene}: {'; '.join(one.broken)}")
        )
    stdout().print(f"noted in {done.changelog}", soft_wrap=True, markup=False)
