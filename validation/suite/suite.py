"""Run all scenes on all engines; measure, judge and store each result when it is complete.

>>> from ghostball.validation import run_suite, select
>>> outcome = run_suite(select(["smoke"]), ["ghostball", "pymunk"], Path("out"))
>>> outcome.exit_status
0
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ghostball.model import Scene
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.checks.verdict import is_unfinished, not_judged
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.parallel.cluster import Cluster
from ghostball.validation.parallel.pool import Progress
from ghostball.validation.parallel.sources import code_kind
from ghostball.validation.results.record_store import Name
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.results.store import PartWriter, ResultsWriter
from ghostball.validation.runs.runner import Reuse, check_limits, run
from ghostball.validation.suite.case import cases_of, finished, prepare, run_case
from ghostball.validation.suite.ensemble import Ensemble
from ghostball.validation.suite.plan import plan
from ghostball.validation.suite.unchanged import code_hash, code_with_engines

DEFAULT_ENGINES: tuple[str, ...] = (
    "ghostball",
    "pymunk",
    "pymunk:contact_steps=exact",
    "pymunk:config=naive",
    "pybullet",
    "pybullet:contact_steps=exact",
    "pybullet:config=naive",
    "paper-discrete",
    "paper-continuous",
)
"""The engines of `ghostball validate` without `--engine`."""


@dataclass(frozen=True)
class Counts:
    """Number of cases by outcome, and of checks by verdict.

    A case is unfinished if it failed, or if it stopped before the end of the shot.
    """

    ran: int = 0
    unavailable: int = 0
    failed: int = 0
    unfinished: int = 0
    checks_passed: int = 0
    checks_failed: int = 0
    checks_reference: int = 0
    checks_left_out: int = 0
    reused: int = 0


@dataclass(frozen=True, eq=False)
class SuiteResult:
    """The result of a run.

    `cases`: finished cases: reused cases first, then the other cases in order of completion.
    `planned`: number of planned cases.
    `interrupted`: whether Ctrl-C ended the run; the folder then holds the finished cases.
    `begun`: whether the results of this run, possibly empty, replaced earlier results in the
        folder.
    """

    folder: Path
    cases: list[CaseRecord] = field(default_factory=list)
    planned: int = 0
    interrupted: bool = False
    begun: bool = False

    @property
    def counts(self) -> Counts:
        """Cases by outcome and checks by verdict."""
        outcomes = [case.outcome for case in self.cases]
        verdicts = [check.passed for case in self.cases for check in case.checks]
        return Counts(
            ran=outcomes.count("ran"),
            unavailable=outcomes.count("unavailable"),
            failed=outcomes.count("failed"),
            unfinished=sum(is_unfinished(case) for case in self.cases),
            checks_passed=verdicts.count(True),
            checks_failed=verdicts.count(False),
            checks_reference=verdicts.count(None),
            checks_left_out=sum(len(case.left_out) for case in self.cases),
            reused=sum(case.reused for case in self.cases),
        )

    @property
    def exit_status(self) -> ExitStatus:
        """0 all passed; 1 a check failed, or an engine didn't finish; 130 interrupted.

        3 Ghostball itself failed to judge a case; 4 nothing was judged, or no final position of
        some engine was judged (`unjudged_engines`).
        """
        return ExitStatus.INTERRUPTED if self.interrupted else exit_status_of(self.cases)


def exit_status_of(cases: Collection[CaseRecord]) -> ExitStatus:
    """Return the exit status for these cases, as in `SuiteResult.exit_status`."""
    if any(case.fault == "ghostball" for case in cases):
        return ExitStatus.HARNESS_FAILED
    if any(map(is_unfinished, cases)) or any(
        check.passed is False for case in cases for check in case.checks
    ):
        return ExitStatus.CHECK_FAILED
    return ExitStatus.NOT_JUDGED if not_judged(cases) else ExitStatus.PASSED


def run_suite(
    scenes: Sequence[Scene],
    engine_specs: Sequence[str],
    out: Path,
    *,
    jobs: int = 1,
    cluster: Cluster | None = None,
    progress: Progress[CaseRecord] | None = None,
    compiling: Progress[str] | None = None,
    criteria: Mapping[str, Criteria] | None = None,
    metrics: Sequence[str] | None = None,
    reuse: bool = False,
    announce: Callable[[Reuse[CaseRecord]], None] | None = None,
    time_limit: float | None = None,
    only: Collection[Name] | None = None,
    ensemble: Ensemble | None = None,
    keeps_motion: bool = True,
    relations: Sequence[str] | None = None,
) -> SuiteResult:
    """Run every scene on every engine and write a results folder.

    Parameters
    ----------
    scenes : sequence of Scene
        Names must differ.
    engine_specs : sequence of str
        `NAME` or `NAME:key=value,...`; a known engine that can't run here gives cases that report
        this.
    out : Path
        The results folder. Earlier results in it are replaced when the first case finishes.
    jobs : int
        Number of processes. With 1 and no `time_limit`, everything runs in this process, so an
        engine that crashes ends it. Use 1 for reliable run times.
    cluster : Cluster, optional
        Runs the cases instead; `jobs` processes then only compile.
    progress : callable, optional
        Called after each case that runs, with the number of finished cases, the number of all
        cases, and the last case; not called for reused cases.
    compiling : callable, optional
        Called with the progress of compiling kernels of Ghostball's engine; see `compile_kernels`.
    criteria : mapping of str to Criteria, optional
        By scene name. Without an entry, a scene that equals a shipped one has the shipped criteria.
    metrics : sequence of str, optional
        Names, or patterns such as "rest_error_*", of the metrics that are computed and judged;
        default: the usual ones, and those with a limit. Criteria on other metrics aren't judged:
        `CaseRecord.left_out`.
    reuse : bool
        Reuse cases that are unchanged since an earlier run into the same folder instead of running
        them again; see `validation.suite.unchanged`.
    announce : callable, optional
        Called once, before anything runs, with the reused results.
    time_limit : float, optional [s]
        For each case. Cases then run in other processes, even with one job: an engine that exceeds
        the limit, or crashes, makes only that case "failed". An engine of another project gets
        processes of its own, so it can't affect the cases of other engines. Guard a script with `if
        __name__ == "__main__"`.
    only : collection of (str, str), optional
        The scene and label of each case to run, if not every scene runs on every engine. Other
        results of the same code in the folder are then kept.
    ensemble : Ensemble, optional
        Also run perturbed initial states of each scene, as cases; see `suite.statistics`.
    keeps_motion : bool
        Whether the motion of each case is stored; pictures and replays need it.
    relations : sequence of str, optional
        Also simulate related shots, and judge these relations: see `checks.relations`. Empty: all
        relations. Default: none.

    Raises
    ------
    GhostballError
        Before anything is simulated: if an engine, a setting or a metric is unknown, if the
        criteria are invalid, or if the folder can't be used, for example because another run is
        writing there.

    Notes
    -----
    Each case is recorded with its whole motion, stored or not. The reference result of a scene is
    computed once. After Ctrl-C, the run stops, keeps the finished cases and sets
    `SuiteResult.interrupted`; results of earlier runs that this run has not replaced yet are kept,
    too, for a later run with `reuse`.
    """
    check_limits(jobs, time_limit)
    planned = plan(
        scenes, engine_specs, criteria or {}, metrics, only, ensemble, keeps_motion, relations
    )
    code = code_hash()
    store = (ResultsWriter if only is None else PartWriter)(out, code, code_with_engines(code))
    ran = run(
        planned.inputs,
        lambda pairs: cases_of(planned, pairs),
        run_case,
        finished,
        store,
        jobs=cluster or jobs,
        limit=time_limit,
        prepare=lambda pairs: prepare(planned, pairs, jobs, compiling),
        kind=lambda case: code_kind(case.label),
        about=planned.describe,
        reuse=reuse,
        announce=announce,
        progress=progress,
    )
    return SuiteResult(out, list(ran.records.values()), planned.size, ran.interrupted, ran.begun)
