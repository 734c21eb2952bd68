"""`ghostball grade`: check runs that engines in any language have written to files."""

from __future__ import annotations

import typer
from rich.markup import escape

from ghostball.cli.measure.commands import GradeOptions
from ghostball.cli.measure.grade_golden import grade_golden
from ghostball.cli.measure.verdicts import failure_lines
from ghostball.cli.shared.tables import table_of
from ghostball.cli.shared.terminal import say, stdout
from ghostball.model import GhostballError, Scene
from ghostball.reference_adapters.answer import EngineAnswer
from ghostball.reference_adapters.base import EngineError
from ghostball.reference_adapters.registry import engine_names
from ghostball.reference_adapters.run_files import load_runs, recorded_engine
from ghostball.reports.accuracy import cell_text
from ghostball.validation.checks.requirements import asked_of
from ghostball.validation.checks.verdict import few_ends_judged, not_judged
from ghostball.validation.exit_status import ExitStatus, worst
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.scenes.library import find_scene, scene_names
from ghostball.validation.suite.case import run_case, truth_or_failure
from ghostball.validation.suite.judge import Case
from ghostball.validation.suite.plan import shipped_criteria
from ghostball.validation.suite.suite import exit_status_of


def run(asked: GradeOptions) -> ExitStatus:
    """Check each run as `validate` checks an engine, and print the verdicts.

    A file without a complete run counts as "did not finish": an engine that crashed or hung leaves
    such a file.

    Raises `EngineError` if a run has an invalid engine name or scene, after the valid runs are
    printed.
    """
    if asked.golden is not None:
        return grade_golden(asked.golden, asked.files, asked.factor)
    if asked.factor is not None:
        raise typer.BadParameter("the option needs `--golden`. Remove `--factor`")
    runs: list[EngineAnswer] = []
    lost: list[str] = []
    for path in asked.files:
        try:
            runs += load_runs(path)
        except EngineError as error:
            lost.append(str(error))
    cases: list[CaseRecord] = []
    refused: list[str] = []
    for one in runs:
        try:
            cases.append(_judge(one))
        except EngineError as error:
            refused.append(str(error))
    if cases:
        rows = (
            (
                *map(escape, (case.scene, case.engine, cell_text(case))),
                _counts(case),
                escape(case.reason),
            )
            for case in cases
        )
        heads = ("scene", "engine", "accuracy", "collisions", "message")
        stdout().print(table_of(heads, rows))
    for line in (
        *failure_lines(cases),
        *(f"[bold red]did not finish:[/] {escape(one)}" for one in lost),
    ):
        stdout().print(line, soft_wrap=True)
    for label in dict.fromkeys(case.label for case in cases):
        if said := few_ends_judged([case for case in cases if case.label == label]):
            stdout().print(f"{escape(label)}: {said}", soft_wrap=True)
    if refused:  # last, so that the valid runs are printed
        raise EngineError("\n".join(refused))
    if lost:
        return worst(ExitStatus.CHECK_FAILED, exit_status_of(cases))
    if why := not_judged(cases):
        say(f"[bold yellow]{escape(why)}.[/]")
    return exit_status_of(cases)


def _counts(case: CaseRecord) -> str:
    found, true = sum(case.collision_counts.values()), case.truth_counts
    return f"{found}" if true is None else f"{found} of {sum(true.values())}"


def _judge(run: EngineAnswer) -> CaseRecord:
    if run.engine in engine_names():
        raise EngineError(
            f"`engine` of a run must not be {run.engine!r}, the name of an installed engine: "
            "limits depend on the name. Rename the engine of the run, or run the installed engine "
            "with `ghostball validate`"
        )
    scene = _scene_of(run)
    criteria = shipped_criteria(scene)
    truth = truth_or_failure(scene, criteria)
    case = Case(scene, run.engine, truth, asked_of([(run.engine, run.settings)], criteria))
    record, _ = run_case(case, lambda _: recorded_engine(run))
    return record


def _scene_of(run: EngineAnswer) -> Scene:
    if isinstance(run.scene, str):
        if run.scene not in scene_names():  # an untrusted run must not open files by path
            raise EngineError(
                "`scene` of a run must be the name of a shipped scene, or the whole scene as an "
                f"object, got {run.scene!r:.100}. `ghostball scenes` lists the names"
            )
        return find_scene(run.scene)
    try:
        return Scene.model_validate(run.scene)
    except (GhostballError, ValueError) as error:
        raise EngineError(f"invalid scene in a run of `{run.engine}`: {error}") from None
