"""What `ghostball validate` does: choose, run, write the report, show the verdicts."""

from __future__ import annotations

import shlex
import time
from collections.abc import Sequence
from pathlib import Path

from rich.markup import escape

from ghostball import _ensembles, _report
from ghostball._progress import counting
from ghostball._terminal import ExitStatus, check_writable, say, say_printed, stdout, worst
from ghostball._verdicts import colour_of, verdict_tables
from ghostball.engine import Scene
from ghostball.reference_adapters import make_engine, split_specs
from ghostball.validation.baselines import (
    check_baselines,
    compare_results,
    save_regression,
)
from ghostball.validation.baselines.baseline import FOLDER, baseline_path
from ghostball.validation.checks.criteria import SUFFIX
from ghostball.validation.checks.verdict import (
    NOTHING_JUDGED,
    Verdict,
    is_nothing_judged,
    verdict_of,
)
from ghostball.validation.diagnose.predictability.predict import predict_scenes
from ghostball.validation.parallel.cluster import Cluster
from ghostball.validation.results.records import COMPLETE_STATUSES
from ghostball.validation.results.store import CaseRecord, Results, has_results
from ghostball.validation.scenes.library import Suite, scene_names, select
from ghostball.validation.suite.junit import write_junit
from ghostball.validation.suite.suite import (
    DEFAULT_ENGINES,
    Outcome,
    criteria_beside_paths,
    run_suite,
)
from ghostball.validation.suite.unchanged import Unchanged
from ghostball.validation.truth.scene_truth import OUR_NAME


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
    cluster: Cluster | None,
    time_limit: float,
    report: bool,
    figures: bool,
    ensemble: int | None,
    ensemble_size: str | None,
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
            cluster=cluster,
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
    results = Results.open(out)
    if junit is not None:
        write_junit(results.cases, junit)
    # What was measured is said before anything is made of it: whatever may yet fail or be
    # interrupted, the verdicts are there.
    console = stdout()
    console.print(verdict_tables(results, console))
    console.print(_headline(outcome, time.perf_counter() - started), soft_wrap=True)
    if outcome.counts.taken_over:
        console.print(f"{_taken_over(outcome.counts.taken_over, out)}; their run times are of then")
    _say_all_printed(outcome)
    if is_nothing_judged(outcome.cases):
        say(f"[bold yellow]{NOTHING_JUDGED}.[/] {escape(_advice(outcome))}")
    status = ExitStatus.PASSED
    try:
        if outcome.interrupted or not _predict(scenes, out, reuse=not rerun):
            raise KeyboardInterrupt
        shipped = [one for one in scenes if one.name not in criteria or _has_baseline(one)]
        if changed := _compare(results, shipped, whole=patterns is None):
            console.print(changed, soft_wrap=True)
        if request is not None:
            status = _ensembles.run(
                request,
                scenes,
                specs,
                out,
                jobs=jobs,
                cluster=cluster,
                rerun=rerun,
                time_limit=time_limit,
            )
            if status is ExitStatus.INTERRUPTED:  # that was said
                return status
            status = worst(status, _ensembles.show(out))
        if report:
            written = _report.write(out, jobs=jobs, figures=figures)
            console.print(f"page: {written.page}", soft_wrap=True, markup=False)
            console.print(f"report: {written.report}", soft_wrap=True, markup=False)
            status = worst(status, written.status())
    except KeyboardInterrupt:
        say(
            f"[bold]Interrupted:[/] {len(outcome.cases)} of {outcome.planned} cases are done and "
            f"kept in {folder}; `ghostball report {folder}` reports on them, and "
            "`validate` without --rerun goes on from there"
        )
        return ExitStatus.INTERRUPTED
    return worst(outcome.exit_status, status)


def _has_baseline(scene: Scene) -> bool:
    return baseline_path(FOLDER, scene.name).exists()


def _compare(results: Results, scenes: Sequence[Scene], *, whole: bool) -> str:
    """Compare our engine with its baselines where it ran; store that, and return it in words.

    It is shown, not judged: `ghostball regress` is the gate. Nothing is compared where not the
    `whole` of the metrics was computed, nor of a user's own scene, which has no baseline here.

    Raises
    ------
    KeyboardInterrupt
    """
    ran = {
        case.scene
        for case in results.cases
        if case.label == OUR_NAME and case.status in COMPLETE_STATUSES
    }
    compared = [scene for scene in scenes if scene.name in ran]
    if not whole or not compared:
        return ""
    regression = compare_results(
        results,
        whole=False,
        only={scene.name for scene in scenes},
        candidates=False,
    )
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
        say(f"nothing is taken over from {escape(str(out))}: {escape(why)}")
    if unchanged.stored and unchanged.always:
        say(f"always run, for other packages bring them: {escape(', '.join(unchanged.always))}")


def _taken_over(count: int, out: Path) -> str:
    cases = "1 case" if count == 1 else f"{count} cases"
    return f"{cases} unchanged, taken over from {escape(str(out))} (run again with --rerun)"


def _left(outcome: Outcome) -> str:
    """Say what an interrupted run without a case of its own left in its folder."""
    if not has_results(outcome.folder):
        return "no results"
    if not outcome.begun:
        return "the results stay as they were"
    return "no results yet, but what earlier runs found and a next run may take over is kept"


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
    if counts.unfinished:
        parts.append(f"cases that did not finish: {counts.unfinished}")
    if counts.unavailable:
        parts.append(f"cases without their engine here: {counts.unavailable}")
    colour = "green" if outcome.exit_status == 0 else "bold red"
    return f"[{colour}]{', '.join(parts)}[/] in {seconds:.0f} s"


def _advice(outcome: Outcome) -> str:
    """Say why no limit judges what was run, and how to have it judged."""
    if outcome.counts.checks_left_out:
        return "--metrics leaves out every limit. Ask for a metric that has one"
    ran = [case for case in outcome.cases if case.outcome == "ran"]
    if not ran:
        return (
            "No engine that was asked can play these scenes. `ghostball engines` says what each can"
        )
    unlimited = [case for case in ran if not case.checks]
    if not unlimited:
        return "Every limit compares our engine with itself. Add engines"
    case = next((one for one in unlimited if one.scene not in scene_names()), unlimited[0])
    if case.scene in scene_names():
        return (
            f"The shipped scenes have no limits for `{case.engine}`. What no engine may break, and "
            "limits of yours, are judged by "
            f"`pytest ghostball:: --ghostball-engine {shlex.quote(case.label)}`"
        )
    return (
        f"Say what must hold in {case.scene}{SUFFIX} beside the scene, such as:\n"
        f'[[criteria]]\nengines = ["{case.engine}"]\nmetric = "rest_error_max"\nat_most = 5e-3\n'
        'reason = "why no more than 5 mm"'
    )


def _say_all_printed(outcome: Outcome) -> None:
    """Show what each engine printed in one scene, the first, and how many more there are."""
    for label in dict.fromkeys(case.label for case in outcome.cases if case.printed):
        cases = [case for case in outcome.cases if case.label == label and case.printed]
        say_printed(label, cases[0].printed)
        more = f", and in {len(cases) - 1} more cases: the report has them" * (len(cases) > 1)
        say(escape(f"engine {label} printed that in scene {cases[0].scene}{more}"))
