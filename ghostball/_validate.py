"""What `ghostball validate` does: choose, run, write the report, show the verdicts."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

from rich.markup import escape

from engine import Scene
from ghostball import _ensembles, _report
from ghostball._progress import counting
from ghostball._terminal import ExitStatus, check_writable, say, stdout
from ghostball._verdicts import colour_of, verdict_tables
from reference_adapters import make_engine, split_specs
from validation.attribution import attribute_results
from validation.environment import describe_environment
from validation.junit import write_junit
from validation.library import Suite, select
from validation.predictability.predict import predict_scenes
from validation.records import COMPLETE_STATUSES
from validation.regression import (
    MachineTimes,
    check_baselines,
    compare_results,
    load_times,
    save_regression,
    time_scenes,
    times_path,
)
from validation.regression.baseline import FOLDER
from validation.store import CaseRecord, ResultsFolder, is_results_folder, read_earlier
from validation.suite import DEFAULT_ENGINES, Outcome, criteria_beside_paths, run_suite
from validation.truth import OUR_NAME
from validation.unchanged import Unchanged
from validation.verdict import Verdict, verdict_of

SHOWN = 3
"""How many of the motions that are damaged are named."""


def run(
    names_or_tags: Sequence[str],
    *,
    suite: Suite,
    engines: str | None,
    out: Path,
    metrics: str | None,
    rerun: bool,
    junit: Path | None,
    jobs: int,
    time_limit: float,
    report: bool,
    figures: bool,
    ensemble: int | None,
    ensemble_size: str | None,
    attribute: bool,
) -> int:
    """Validate, and return the exit status; see the options of the command.

    Raises
    ------
    GhostballError
        Before anything runs, where the input is wrong, an engine asked for by name can't run
        here, a metric is unknown, or a file can't be written.
    """
    specs = DEFAULT_ENGINES if engines is None else split_specs(engines)
    if engines is not None:
        # Who names an engine wants its verdict; of the default ones, those that are here will do.
        for spec in specs:
            make_engine(spec)
    scenes, criteria = select(names_or_tags, suite), criteria_beside_paths(names_or_tags)
    check_baselines(FOLDER, [scene.name for scene in scenes])
    known = load_times(times_path(FOLDER, describe_environment()))
    patterns = None if metrics is None else [name.strip() for name in metrics.split(",")]
    request = None
    if ensemble is not None:
        request = _ensembles.EnsembleRequest.checked(ensemble, ensemble_size, scenes, specs, out)
    if junit is not None:
        check_writable(junit, "--junit")
    started = time.perf_counter()
    with counting("running") as count:

        def progress(case: CaseRecord, done: int, planned: int) -> None:
            count(done, planned, f"{case.scene} on {case.label}")
            if verdict_of(case) in (Verdict.FAIL, Verdict.CRASHED):
                verdict = verdict_of(case).words
                say(f"[{colour_of(case)}]{verdict}[/] {escape(f'{case.scene} on {case.label}')}")

        outcome = run_suite(
            scenes,
            specs,
            out,
            jobs=jobs,
            progress=progress,
            criteria=criteria,
            metrics=patterns,
            reuse=not rerun,
            announce=lambda unchanged: _announce(unchanged, out),
            time_limit=time_limit,
        )
    folder = escape(str(out))
    if not outcome.cases:
        say(f"[bold]Interrupted[/] before the first case was done: {_left(outcome)} in {folder}")
        return outcome.exit_status
    results = ResultsFolder.load(out)
    if junit is not None:
        write_junit(results.cases, junit)
    # What was measured is said before anything is made of it: whatever may yet fail or be
    # interrupted, the verdicts are there.
    console = stdout()
    console.print(verdict_tables(results, console))
    console.print(_headline(outcome, time.perf_counter() - started), soft_wrap=True)
    if outcome.counts.taken_over:
        console.print(f"{_taken_over(outcome.counts.taken_over, out)}; their run times are of then")
    if not any(check.passed is not None for case in outcome.cases for check in case.checks):
        say(f"[bold yellow]warning:[/] {escape(_nothing_judged(outcome))}")
    status = ExitStatus.PASSED
    try:
        if outcome.interrupted or not _predict(scenes, out, reuse=not rerun):
            raise KeyboardInterrupt
        if changed := _compare(results, scenes, known, whole=patterns is None):
            console.print(changed, soft_wrap=True)
        if request is not None:
            status = _ensembles.run(
                request, scenes, specs, out, jobs=jobs, rerun=rerun, time_limit=time_limit
            )
            if status is ExitStatus.INTERRUPTED:  # that was said
                return status
            status = max(status, _ensembles.show(out))
        if attribute:
            with counting("attributing") as count:
                attribute_results(results, progress=count, jobs=jobs, time_limit=time_limit)
        if report:
            written = _report.write(out, jobs=jobs, figures=figures)
            console.print(f"page: {written.page}", soft_wrap=True, markup=False)
            console.print(f"report: {written.report}", soft_wrap=True, markup=False)
            status = max(status, written.status())
    except KeyboardInterrupt:
        say(
            f"[bold]Interrupted:[/] {len(outcome.cases)} of {outcome.planned} cases are done and "
            f"kept in {folder}; `ghostball report {folder}` reports on them, and "
            "`validate` without --rerun goes on from there"
        )
        return ExitStatus.INTERRUPTED
    return max(outcome.exit_status, status)


def _compare(
    results: ResultsFolder, scenes: Sequence[Scene], known: MachineTimes | None, *, whole: bool
) -> str:
    """Compare our engine with its baselines where it ran; store that, and return it in words.

    It is shown, not judged: `ghostball regress` is the gate. Nothing is compared where not the
    `whole` of the metrics was computed.

    Raises
    ------
    KeyboardInterrupt
    """
    ran = {
        case.scene
        for case in results.cases
        if case.label == OUR_NAME and case.status in COMPLETE_STATUSES
    }
    if not whole or not ran:
        return ""
    with counting("timing") as count:
        times = time_scenes([scene for scene in scenes if scene.name in ran], progress=count)
    regression = compare_results(results, whole=False, candidates=False, times=times, known=known)
    save_regression(regression, results.path)
    moved = [one.scene for one in regression.scenes if one.failed]
    if not moved:
        return ""
    return (
        "[yellow]our engine moved since its baselines were accepted:[/] "
        f"{escape(', '.join(moved))}; `ghostball regress` says how"
    )


def _predict(scenes: Sequence[Scene], out: Path, *, reuse: bool) -> bool:
    """Store how far each scene's shot can be predicted; whether it came to its end."""
    try:
        with counting("predicting") as count:
            predict_scenes(scenes, out, reuse=reuse, progress=count)
    except KeyboardInterrupt:
        return False
    return True


def _announce(unchanged: Unchanged, out: Path) -> None:
    """Say what isn't run again, or why all is, where there are results to take over."""
    if unchanged.cases:
        say(_taken_over(len(unchanged.cases), out))
    elif unchanged.stored or unchanged.why:
        why = unchanged.why or "scene, settings, criteria or metrics of every case differ"
        if unchanged.damaged and not unchanged.why:
            why = "what is unchanged is damaged"
        say(f"nothing is taken over from {escape(str(out))}: {escape(why)}")
    if unchanged.stored and unchanged.always:
        say(f"always run, for other packages bring them: {escape(', '.join(unchanged.always))}")
    first, others = unchanged.damaged[:SHOWN], len(unchanged.damaged) - SHOWN
    for name in first:
        say(f"run again, for its motion is missing or damaged: {escape(str(out / name))}")
    if others > 0:
        say(f"run again, for their motion is missing or damaged: {others} more")


def _taken_over(count: int, out: Path) -> str:
    cases = "1 case" if count == 1 else f"{count} cases"
    return f"{cases} unchanged, taken over from {escape(str(out))} (run again with --rerun)"


def _left(outcome: Outcome) -> str:
    """Say what an interrupted run without a case of its own left in its folder."""
    if not is_results_folder(outcome.folder):
        return "no results"
    if not outcome.begun:
        return "the results stay as they were"
    if read_earlier(outcome.folder):
        return "no results yet, but the earlier ones that a next run may take over are put by"
    return "no results"


def _headline(outcome: Outcome, seconds: float) -> str:
    counts = outcome.counts
    parts = [
        f"{counts.checks_passed} checks passed",
        f"{counts.checks_failed} failed",
    ]
    if counts.checks_reference:
        parts.append(f"{counts.checks_reference} only compare our engine with itself")
    if counts.checks_left_out:
        parts.append(f"{counts.checks_left_out} left out by --metrics")
    if counts.failed:
        parts.append(f"cases that did not finish: {counts.failed}")
    if counts.unavailable:
        parts.append(f"cases without their engine here: {counts.unavailable}")
    colour = "green" if outcome.exit_status == 0 else "bold red"
    return f"[{colour}]{', '.join(parts)}[/] in {seconds:.0f} s"


def _nothing_judged(outcome: Outcome) -> str:
    """Say that a run passed only because nothing was judged, and how to have it judged."""
    if outcome.counts.checks_left_out:
        return "no check was made: --metrics leaves out every limit. Ask for a metric that has one"
    names = dict.fromkeys(case.scene for case in outcome.cases if not case.checks)
    if not names:
        return "no check was made: every limit compares our engine with itself. Add engines"
    files = ", ".join(f"{name}.expect.toml" for name in list(names)[:3])
    more = ", ..." if len(names) > 3 else ""
    return (
        f"no check was made: nothing here has a limit. Write {files}{more} beside the scene, or "
        "add engines that its criteria cover"
    )
