"""What `ghostball regress` and `accept` do."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Container, Sequence
from pathlib import Path

from rich import box
from rich.markup import escape
from rich.table import Table

from ghostball._progress import counting
from ghostball._terminal import ExitStatus, check_writable, say, stdout, worst
from ghostball.engine import Scene
from ghostball.validation.baselines import (
    LimitsBrokenError,
    NotComparableError,
    Regression,
    SceneChange,
    accept,
    baseline_folder,
    can_be_accepted,
    check_baselines,
    compare_results,
    compare_revisions,
    save_regression,
)
from ghostball.validation.baselines.gate import crowds, with_cases
from ghostball.validation.baselines.junit import write_regression_junit
from ghostball.validation.baselines.regression import BASELINES, Change
from ghostball.validation.baselines.timing import ROUNDS
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.results.store import Results
from ghostball.validation.scenes.library import scene_names, select
from ghostball.validation.suite.suite import Outcome, criteria_beside_paths, run_suite
from ghostball.validation.truth.scene_truth import OUR_NAME

_COLOURS: dict[Change, str] = {
    "identical": "green",
    "rounding-only": "yellow",
    "better": "cyan",
    "results-changed": "bold red",
    "worse": "bold red",
    "no-baseline": "yellow",
    "not-comparable": "yellow",
}

_WORDS: dict[Change, str] = {
    "identical": "identical",
    "rounding-only": "rounding only",
    "better": "better against truth",
    "results-changed": "results changed",
    "worse": "worse against truth",
    "no-baseline": "no baseline",
    "not-comparable": "not comparable",
}

_VERDICTS = {
    ExitStatus.PASSED: "[green]passed[/]",
    ExitStatus.CHECK_FAILED: "[bold red]failed[/]",
    ExitStatus.HARNESS_FAILED: "[bold red]failed[/]",
    ExitStatus.NOT_JUDGED: "[bold yellow]no baseline[/]",
}


def run(
    names_or_tags: Sequence[str],
    *,
    against: str | None,
    baselines: Path | None,
    out: Path,
    junit: Path | None,
    jobs: int,
    rerun: bool,
    time_limit: float,
    timed: bool,
    as_json: bool,
) -> ExitStatus:
    """Compare, print what changed, and return the exit status; see the options of the command.

    Raises
    ------
    GhostballError
        Before anything runs, where the input is wrong or a baseline is nonsense.
    """
    folder = baseline_folder(baselines)
    scenes, criteria = select(names_or_tags), criteria_beside_paths(names_or_tags)
    if junit is not None:
        check_writable(junit, "--junit")
        junit.unlink(missing_ok=True)  # of an earlier run: an interrupt must not leave it behind
    if against is None:
        made = () if names_or_tags else crowds()
        check_baselines(folder, [scene.name for scene in (*scenes, *made)])
    started = time.perf_counter()
    with counting("running") as count:

        def progress(case: CaseRecord, done: int, planned: int) -> None:
            count(done, planned, case.scene)

        outcome = run_suite(
            scenes,
            [OUR_NAME],
            out,
            jobs=jobs,
            progress=progress,
            criteria=criteria,
            reuse=not rerun,
            time_limit=time_limit,
        )
    if outcome.interrupted:
        say("[bold]Interrupted:[/] nothing was compared. The same command goes on from there")
        return ExitStatus.INTERRUPTED
    results = Results.open(out)
    try:
        if against is not None:
            with counting("comparing") as count:
                regression = compare_revisions(
                    _chosen(scenes, {one.scene for one in outcome.cases if one.outcome == "ran"}),
                    against,
                    out,
                    criteria=criteria,
                    rounds=ROUNDS if timed else 0,
                    progress=count,
                )
                regression = with_cases(regression, results)
        else:
            regression = compare_results(results, folder, whole=not names_or_tags)
    except NotComparableError as error:
        say(f"[bold red]error:[/] {escape(str(error))}")
        if junit is not None:
            nothing = Regression(
                against=against or BASELINES,
                base={},
                head={},
                outcome="no-baseline",
                scenes=(),
                warnings=(str(error),),
            )
            write_regression_junit(nothing, junit)
        return ExitStatus.NOT_JUDGED
    save_regression(regression, out)
    if junit is not None:
        write_regression_junit(regression, junit)
    if as_json:
        print(regression.model_dump_json(by_alias=True))
    else:
        _show(regression, outcome, out, baselines, time.perf_counter() - started)
    return _status(regression, outcome)


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
    regression: Regression, outcome: Outcome, out: Path, baselines: Path | None, seconds: float
) -> None:
    console = stdout()
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
        _show_times(regression)
    if changed or new or regression.stale:
        folder = escape(str(out))
        say(f"`ghostball report {folder}` shows it, old and new side by side")
        if regression.accepted:
            _say_what_next(regression, out, baselines)


def _say_what_next(regression: Regression, out: Path, baselines: Path | None) -> None:
    """Say how to accept what moved, where that may be right."""
    if regression.broken:
        names = ", ".join(one.scene for one in regression.broken)
        say(f"Limits of truth are broken, so this is to be mended, not accepted: {escape(names)}")
        return
    shipped = {*scene_names(), *(scene.name for scene in crowds())}
    own = [one.scene for one in regression.scenes if one.change == "no-baseline"]
    homeless = [name for name in own if name not in shipped] if baselines is None else []
    if homeless:
        say(
            "Ghostball keeps no baselines of scenes of your own, such as "
            f"{escape(', '.join(homeless))}: give a folder for them, by `--baselines DIR`"
        )
    moved = [one for one in regression.scenes if can_be_accepted(one) and one.scene not in homeless]
    if moved or regression.stale:
        given = "" if out == Path("out/regress") else f" --from {escape(str(out))}"
        given += "" if baselines is None else f" --baselines {escape(str(baselines))}"
        say(f'Where it is right: `ghostball accept{given} --reason "..."`')


def _show_times(regression: Regression) -> None:
    times = [one.time for one in regression.scenes if one.time is not None]
    ratios = sorted(one.ratio for one in times)
    if ratios:
        middle = ratios[len(ratios) // 2]
        stdout().print(
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
    out: Path,
    reason: str,
    *,
    only: str,
    baselines: Path | None,
    even_though_limits_fail: bool,
) -> ExitStatus:
    """Accept, say what was written, and return the exit status."""
    try:
        done = accept(
            out,
            reason,
            only=only,
            folder=baseline_folder(baselines),
            even_though_limits_fail=even_though_limits_fail,
        )
    except LimitsBrokenError as error:
        say(f"[bold red]error:[/] {escape(str(error))}, or say --even-though-limits-fail")
        return ExitStatus.CHECK_FAILED
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
    return ExitStatus.PASSED
