"""`ghostball validate`: run scenes on engines, print the verdicts, and write the report."""

from __future__ import annotations

import time
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

import typer
from rich.console import Console
from rich.markup import escape

from ghostball.cli.gate.regress import compare_with_baselines
from ghostball.cli.measure.commands import ValidateOptions
from ghostball.cli.measure.verdicts import (
    agreement_table,
    colour_of,
    details_table,
    ensemble_table,
    headline,
    verdict_tables,
)
from ghostball.cli.shared.config import load_config, named_engines
from ghostball.cli.shared.hints import hints
from ghostball.cli.shared.progress import COMPILING, DRAWING, RUNNING, Steps
from ghostball.cli.shared.relations import relations_of, relations_table, say_never_judged
from ghostball.cli.shared.report import print_for_programs, write as write_report
from ghostball.cli.shared.running import reused_text, run_cases, say_all_printed
from ghostball.cli.shared.terminal import busy, say, tables
from ghostball.model import Scene
from ghostball.reference_adapters import (
    EngineError,
    engine_class,
    engine_names,
    names_class,
    parse_spec,
)
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.baselines import Gate, Regression
from ghostball.validation.baselines.regression import UNCOMPARED, FailOn
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.checks.verdict import Verdict, is_nothing_judged, not_judged, verdict_of
from ghostball.validation.exit_status import ExitStatus, worst
from ghostball.validation.results.records import CERTIFIED, CLOSED_FORM, INTEGRATION, OUR_ENGINE
from ghostball.validation.results.store import CaseRecord, Results, has_results
from ghostball.validation.scenes import commands
from ghostball.validation.scenes.library import BOARD, CRITERIA_SUFFIX, FULL, scene_names, select
from ghostball.validation.suite.ensemble import Ensemble, PerturbationSize
from ghostball.validation.suite.plan import criteria_beside_paths
from ghostball.validation.suite.real_tables import measure_agreements
from ghostball.validation.suite.statistics import ensemble_verdicts
from ghostball.validation.suite.suite import DEFAULT_ENGINES, SuiteResult, run_suite


@dataclass(frozen=True)
class _ValidationPlan:
    """The scenes and engines of a run, and the checked options.

    `criteria`: limits from files beside the scenes, by scene name.
    `engines`: labels of all engines that run.
    `asked`: these engines without Ghostball's, if it runs only for replays or for an ensemble.
    `named`: whether the user or the project names engines.
    `whole`: whether all shipped scenes or the board are asked for.
    """

    scenes: list[Scene]
    criteria: dict[str, Criteria]
    engines: tuple[str, ...]
    asked: tuple[str, ...]
    named: bool
    whole: bool
    gates: list[Gate]
    fail_on: FailOn
    starts: Ensemble | None
    relations: tuple[str, ...] | None
    out: Path


def run(asked: ValidateOptions) -> ExitStatus:
    """Run the scenes, print the verdicts, write the report, and return the exit status."""
    plan = _plan(asked)
    if not plan.named:
        for line in _missing_defaults():
            say(f"[yellow]{escape(line)}[/]")
    steps = Steps(COMPILING, RUNNING, *((DRAWING,) if asked.report else ()))
    started = time.perf_counter()
    outcome = run_cases(
        run_suite,
        plan.scenes,
        plan.engines,
        plan.out,
        asked,
        cluster=asked.cluster,
        steps=steps,
        done=_say_failed,
        criteria=plan.criteria,
        metrics=asked.metric or None,
        ensemble=plan.starts,
        relations=plan.relations,
    )
    folder = escape(str(plan.out))
    if not outcome.cases:
        say(f"[bold]Interrupted[/] before the first case finished: {_left(outcome)} in {folder}")
        return outcome.exit_status
    # The verdicts are printed first: the steps after this one can fail or be interrupted.
    results, console = Results.open(plan.out), tables(asked.form)
    _show(plan, outcome, results, console, time.perf_counter() - started, asked.details)
    status = ExitStatus.PASSED
    try:
        if outcome.interrupted:
            raise KeyboardInterrupt
        if not asked.metric:
            for regression in compare_with_baselines(
                results, plan.gates, plan.scenes, asked.time_limit, plan.fail_on
            ):
                status = worst(status, _say_changed(regression, console))
        with busy("comparing engines with measured tables"):
            beside = plan.engines if plan.whole else ()
            measured = measure_agreements(beside, plan.out, asked.time_limit, reuse=not asked.rerun)
        if found := list(measured.records.values()):
            console.print(agreement_table(found), crop=False)
        if measured.interrupted:
            raise KeyboardInterrupt
        if asked.report:
            written = write_report(
                plan.out, jobs=asked.jobs, figures=asked.figures.value, steps=steps
            )
            console.print(f"report: {written.page}", soft_wrap=True, markup=False)
            status = worst(status, written.status())
    except KeyboardInterrupt:
        say(
            f"[bold]Interrupted:[/] {len(outcome.cases)} of {outcome.planned} cases are done and "
            f"stored in {folder}; `ghostball report {folder}` makes a report of them, and "
            "`validate` without --rerun continues"
        )
        return ExitStatus.INTERRUPTED
    print_for_programs(plan.out, asked.form)
    if why := not_judged(outcome.cases):  # last, because it explains the exit status
        advice = f" {_advice(outcome)}" if is_nothing_judged(outcome.cases) else ""
        say(f"[bold yellow]{escape(why)}.[/]{escape(advice)}")
    if plan.starts is not None and any(one.failed for one in ensemble_verdicts(results)):
        status = worst(status, ExitStatus.CHECK_FAILED)
    return worst(outcome.exit_status, status, say_never_judged(outcome.cases, plan.relations))


def _plan(asked: ValidateOptions) -> _ValidationPlan:
    """Return the plan of a run; raises an error if an option, engine or scene is invalid."""
    if asked.ensemble_size is not None and asked.ensemble is None:
        raise typer.BadParameter(
            "needs --ensemble K, the number of perturbed initial states",
            param_hint="--ensemble-size",
        )
    config = load_config()
    named = named_engines(asked.engine, config)
    # Replays show an engine over Ghostball's motion, so Ghostball's engine runs too.
    drawn = (OURS,) if asked.report and all(map(names_class, named)) else ()
    names, specs = asked.scenes or config.scenes, named or DEFAULT_ENGINES
    if asked.ensemble is not None and OURS not in specs:
        drawn = (OURS,)  # an ensemble is compared with that of Ghostball's engine
    scenes, gates = select(names), [Gate.of(spec, config.baselines) for spec in specs]
    for gate in gates:
        gate.check(sorted(scene.name for scene in scenes))
    starts = None
    if asked.ensemble is not None:
        size = (
            PerturbationSize.parse(asked.ensemble_size)
            if asked.ensemble_size
            else PerturbationSize()
        )
        starts = Ensemble(asked.ensemble, size)
    return _ValidationPlan(
        scenes,
        criteria_beside_paths(names),
        (*specs, *(drawn if named else ())),
        specs,
        bool(named),
        not asked.metric and (not names or not {FULL, BOARD}.isdisjoint(names)),
        gates,
        config.fail_on,
        starts,
        relations_of(asked.relations),
        asked.out or config.out,
    )


def _missing_defaults() -> Iterator[str]:
    """Yield a line for each default engine that can't run here, with the reason and the remedy."""
    for name in dict.fromkeys(parse_spec(spec)[0] for spec in DEFAULT_ENGINES):
        if reason := engine_class(name).unavailable():
            yield f"Default engine `{name}` was not run: {reason}"


def _say_failed(case: CaseRecord) -> None:
    """Print a case that failed, as soon as it is judged."""
    verdict = verdict_of(case)
    if verdict in (Verdict.FAIL, Verdict.CRASHED):
        where = escape(f"{case.scene} on {case.label}")
        say(f"[{colour_of(case)}]{verdict.words}[/] {where}")


def _show(
    plan: _ValidationPlan,
    outcome: SuiteResult,
    results: Results,
    console: Console,
    seconds: float,
    details: bool,
) -> None:
    """Print the verdicts, then the references, the headline, engines not run, and hints."""
    console.print(verdict_tables(results, console), crop=False)
    if details:
        console.print(details_table(results), crop=False)
    if plan.relations is not None:
        console.print(relations_table(results.cases))
    if plan.starts is not None:
        console.print(ensemble_table(results, plan.starts.size))
    for line in _reference_lines(results, plan.criteria):
        console.print(line, soft_wrap=True)
    console.print(headline(outcome, seconds), soft_wrap=True)
    if count := outcome.counts.reused:
        console.print(f"{reused_text(count, plan.out)}; their run times are from that run")
    say_all_printed(outcome.cases)
    if not plan.named and (others := _other_engines()):
        console.print(f"[dim]{escape(others)}[/]", soft_wrap=True)
    if plan.named:
        for line in hints(outcome.cases, plan.asked):
            console.print(line, soft_wrap=True)


_REFERENCES = {
    CLOSED_FORM: "its closed form",
    CERTIFIED: "a certified result, event by event",
    INTEGRATION: "an integration in 40 digits, not certified; estimated error below 1e-20 m",
    OUR_ENGINE: "the result of Ghostball's own engine, which is not an independent reference",
}


def _reference_lines(results: Results, own: Collection[str]) -> Iterator[str]:
    """Yield the kind of reference result of each scene in a file of the user."""
    for name in own:
        found = {case.truth for case in results.cases if case.scene == name and case.truth}
        for truth in sorted(found):
            yield f"{escape(name)} was compared with {_REFERENCES[truth]}"


def _say_changed(regression: Regression, console: Console) -> ExitStatus:
    """Print the scenes that changed since the baselines were accepted; return the exit status."""
    label, moved = escape(regression.label), [one.scene for one in regression.moved]
    if moved:
        command = escape(commands.regress(engine=regression.label))
        console.print(
            f"[bold red]{label} changed since its baselines were accepted:[/] "
            f"{escape(', '.join(moved))}; `{command}` shows how",
            soft_wrap=True,
        )
        return ExitStatus.CHECK_FAILED
    new = [one.scene for one in regression.scenes if one.change in UNCOMPARED]
    if new:
        console.print(
            f"[yellow]{label} can't be compared with its baselines for[/] "
            f"{escape(', '.join(new))}; `{escape(commands.regress(engine=regression.label))}` "
            "shows why",
            soft_wrap=True,
        )
    return ExitStatus.PASSED


def _left(outcome: SuiteResult) -> str:
    """Return in words what the folder holds if a run stops before its first case."""
    if not has_results(outcome.folder):
        return "no results"
    if not outcome.begun:
        return "the earlier results are unchanged"
    return "no results yet, but results of earlier runs are kept for reuse"


def _other_engines() -> str:
    """Return which engines were not run, and how to run them; "" if there are none."""
    # "certified" is the reference, not an engine to compare with it.
    asked = {parse_spec(spec)[0] for spec in DEFAULT_ENGINES} | {"certified"}
    here: list[str] = []
    absent: list[str] = []
    for name in engine_names():
        if name not in asked:
            (here if _is_installed(name) else absent).append(name)
    parts = []
    if here:
        parts.append(f"Installed but not run (add with `--engine`): {', '.join(here)}")
    if absent:
        parts.append(f"Not installed (see `ghostball engines NAME`): {', '.join(absent)}")
    return ". ".join(parts)


def _is_installed(name: str) -> bool:
    try:
        return engine_class(name).unavailable() is None
    except EngineError:  # a broken package; `ghostball engines` shows the error
        return False


def _advice(outcome: SuiteResult) -> str:
    """Return why no limit judges the run, and how to get a verdict."""
    if outcome.counts.checks_left_out:
        return "--metric leaves out every limit. Choose a metric with a limit"
    ran = [case for case in outcome.cases if case.outcome == "ran"]
    if not ran:
        return (
            "None of the engines supports these scenes. `ghostball engines` lists the features "
            "that each engine supports"
        )
    unlimited = [case for case in ran if not case.checks]
    if not unlimited:
        return "Every limit compares Ghostball's engine with itself. Add another engine"
    case = next((one for one in unlimited if one.scene not in scene_names()), unlimited[0])
    why = f"`{case.label}` is excused from the common limits: {case.excused} "
    why = why if case.excused else ""
    if case.scene in scene_names():
        return f"{why}Choose an engine or settings for which the scene has a limit"
    return (
        f"{why}Add a limit to {case.scene}{CRITERIA_SUFFIX} beside the scene, such as:\n"
        f'[[criteria]]\nengines = ["{case.engine}"]\nmetric = "rest_error_max"\nat_most = 5e-3\n'
        'reason = "why at most 5 mm"'
    )
