"""The suite: scenes x engines, run, measured, judged, and written as they come.

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
from ghostball.validation.suite.plan import plan
from ghostball.validation.suite.unchanged import code_hash, code_with_engines
from ghostball.validation.suite.varied import Ensemble

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
"""What `ghostball validate` runs where `--engine` is left out."""


@dataclass(frozen=True)
class Counts:
    """How many cases, by outcome, and how many checks, by verdict.

    Unfinished is a case that is no run to its end: it failed, or it stopped early.
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
class Outcome:
    """What a run came to.

    `cases`: those that are done: those reused, then the others in order of completion.
    `planned`: how many there would have been.
    `interrupted`: whether the run was cut short by Ctrl-C; the folder then holds what was done.
    `begun`: whether earlier results in the folder gave way to those of this run, be they none.
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
        """0 all passed; 1 a check failed, or an engine didn't come to its end; 130 interrupted.

        3 ghostball itself failed to judge a case; 4 nothing was judged, or not one shot of an
        engine by how it ends (`unjudged_engines`).
        """
        return ExitStatus.INTERRUPTED if self.interrupted else exit_status_of(self.cases)


def exit_status_of(cases: Collection[CaseRecord]) -> ExitStatus:
    """Return what these cases come to, as `Outcome.exit_status` says."""
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
) -> Outcome:
    """Run every scene on every engine and write a results folder.

    Parameters
    ----------
    scenes : sequence of Scene
        Names must differ.
    engine_specs : sequence of str
        `NAME` or `NAME:key=value,...`; an engine that is known but can't run here gives cases
        that say so.
    out : Path
        The results folder; earlier results in it are replaced when the first case that runs is
        done.
    jobs : int
        Processes; 1, without a `time_limit`, runs everything in this one, which an engine that
        crashes then ends. Wall times are best taken with 1.
    cluster : Cluster, optional
        Where the cases run instead; `jobs` processes then only compile.
    progress : callable, optional
        Called with how many cases are done, of how many, and the last; not for what is reused.
    compiling : callable, optional
        How far the compiling of our engine's kernels is, where they aren't; see `compile_kernels`.
    criteria : mapping of str to Criteria, optional
        By scene name. A scene that isn't named here and equals a shipped one has that one's.
    metrics : sequence of str, optional
        Names, or patterns such as "rest_error_*", of the metrics that are computed and judged; all
        where it is left out. A criterion on another metric isn't judged: `CaseRecord.left_out`.
    reuse : bool
        Whether cases that are unchanged since an earlier run into the same folder are reused
        instead of run again; see `validation.suite.unchanged`.
    announce : callable, optional
        Called once, before anything runs, with what is reused of earlier results.
    time_limit : float, optional [s]
        For each case, which then runs in another process, also with one of `jobs`: an engine that
        takes longer, or crashes, costs that case, which has "failed". An engine of another project
        then has processes of its own, so that it can change nothing in the cases of other engines.
        Guard a script with `if __name__ == "__main__"`.
    only : collection of (str, str), optional
        The scene and the label of each case that is run, where not every scene is run on every
        engine. What else the same code left in the folder then stays beside them.
    ensemble : Ensemble, optional
        Varied starts of each scene, which are cases of the run too; see `suite.spread`.
    keeps_motion : bool
        Whether the motion of each case is stored, which pictures and replays need.

    Raises
    ------
    GhostballError
        Before anything is played: where an engine, a setting or a metric is unknown, the criteria
        are wrong, or the folder can't be used, such as while another run writes there.

    Notes
    -----
    Each case is recorded with its whole motion, stored or not. The truth of a scene is computed
    once. Interrupted by Ctrl-C, the run stops, keeps what is done and says so in
    `Outcome.interrupted`; what earlier runs found and this one has not come to is kept too, for a
    later run with `reuse`.
    """
    check_limits(jobs, time_limit)
    planned = plan(scenes, engine_specs, criteria or {}, metrics, only, ensemble, keeps_motion)
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
    return Outcome(out, list(ran.records.values()), planned.size, ran.interrupted, ran.begun)
