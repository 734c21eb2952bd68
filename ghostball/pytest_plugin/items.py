"""The tests of `pytest --ghostball`: collect them, run the scenes, report the results."""

from __future__ import annotations

import math
import shlex
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from statistics import median
from typing import Any

import pytest

from ghostball.cli.shared.config import load_config
from ghostball.model import GhostballError, Scene
from ghostball.pytest_plugin.names import PREFIX, TIME_LIMIT
from ghostball.reference_adapters import ReferenceEngine, engine_names, make_engine
from ghostball.reference_adapters.output import harmless
from ghostball.reference_adapters.registry import OURS
from ghostball.reports.style import format_length
from ghostball.reports.words import many
from ghostball.validation.baselines import ComparedRun, Gate, compare_case
from ghostball.validation.baselines.regression import UNCOMPARED, FailOn
from ghostball.validation.checks.criteria import Criteria, relation_criteria
from ghostball.validation.checks.metrics import METRICS
from ghostball.validation.checks.requirements import Requirements
from ghostball.validation.checks.verdict import not_judged
from ghostball.validation.parallel.sources import is_ours
from ghostball.validation.runs.engine_runs import in_other_process, smallest_supported
from ghostball.validation.runs.runner import check_limits
from ghostball.validation.scenes.commands import regress as regress_command
from ghostball.validation.scenes.library import scene_names, select
from ghostball.validation.suite.conformance import (
    COMPLETES,
    RequirementResult,
    SceneRun,
    Specs,
    asked_of_engine,
    requirement_names,
    run_scene,
)
from ghostball.validation.suite.plan import criteria_beside_paths, own_criteria

DEFAULT_SCENES = "smoke"

_UNJUDGED = "ghostball_unjudged"
"""Name of the test property with the reason why a shot was not judged; "" if it was judged."""

BASELINE = "baseline"
"""Name of the test that compares a scene with its baseline."""


def collect(session: pytest.Session, picked: Sequence[str]) -> list[pytest.Item]:
    """Return the tests; no engine runs.

    `picked`: tests on the command line, such as `ghostball::SCENE::METRIC` or the start of such a
        name; empty selects all tests.

    Raises `pytest.UsageError` if an option or a name is invalid.
    """
    config = session.config
    # Like the commands, append the working directory to the import path, for engines in it.
    for folder in (config.invocation_params.dir, config.rootpath):
        if str(folder) not in sys.path:
            sys.path.append(str(folder))
    try:
        plan = _TestPlan.of(config, picked)
        config.add_cleanup(plan.process.close)
        root = _Node.from_parent(session, name="ghostball", nodeid="ghostball")
        nodes = [
            _SceneNode.from_parent(
                root, name=scene.name, nodeid=f"{PREFIX}{scene.name}", plan=plan, scene=scene
            )
            for scene in plan.scenes
        ]
    except GhostballError as error:
        raise pytest.UsageError(harmless(f"ghostball: {error}")) from None
    _pick(nodes, picked)
    return [item for node in nodes for item in _collected(node)]


def _collected(node: _SceneNode) -> Iterable[pytest.Item]:
    """Return the tests of a node, with the hooks that other plugins need to count them."""
    node.ihook.pytest_collectstart(collector=node)
    report = node.ihook.pytest_make_collect_report(collector=node)
    node.ihook.pytest_collectreport(report=report)
    found: list[pytest.Item] = report.result
    return found


def summary_lines(reports: Iterable[Any]) -> list[str]:
    """Return lines about the rest position errors, from the reports of all processes."""
    errors: dict[str, float] = {}
    found = list(reports)
    for report in found:
        properties = dict(getattr(report, "user_properties", ()))
        scene, value = properties.get("ghostball_scene"), properties.get("rest_error_max")
        if scene is not None and value is not None:
            errors[scene] = value
    not_judged_lines = [why] if (why := unjudged(found)) else []
    if not errors:
        return not_judged_lines
    worst = max(errors, key=errors.__getitem__)
    return [
        f"rest position errors in {many(len(errors), 'scene')}: median "
        f"{format_length(median(errors.values()))}, "
        f"largest {format_length(errors[worst])} in {worst}",
        "Set your own limits with --ghostball-criteria.",
        *not_judged_lines,
    ]


def unjudged(reports: Iterable[Any]) -> str:
    """Return why none of the shots was judged, from `not_judged`; "" if one was judged."""
    properties = [dict(getattr(report, "user_properties", ())) for report in reports]
    said = [found[_UNJUDGED] for found in properties if _UNJUDGED in found]
    return said[0] if said and all(said) else ""


def _pick(nodes: Sequence[_SceneNode], picked: Sequence[str]) -> None:
    """Keep only the picked tests of each scene; with none picked, keep all.

    Raises `pytest.UsageError` if there is no such test.
    """
    if not picked:
        return
    wanted: dict[str, set[str]] = {node.name: set() for node in nodes}
    for pick in picked:
        _, scene, metric, *more = *pick.split("::"), "", ""
        fitting = [node for node in nodes if scene in ("", node.name)]
        found = [(node.name, m) for node in fitting for m in node.metrics if metric in ("", m)]
        if not found or any(more):
            known = ", ".join(m for node in fitting for m in node.metrics) if scene else ""
            hint = f"The tests of this scene are: {known}" if known else "See --ghostball-scenes"
            raise pytest.UsageError(f"ghostball: there is no test `{pick}`. {hint}")
        for name, of_scene in found:
            wanted[name].add(of_scene)
    for node in nodes:
        node.metrics = tuple(metric for metric in node.metrics if metric in wanted[node.name])


@dataclass(frozen=True, eq=False)
class _TestPlan:
    """Engine, scenes and limits of the tests, from the checked options.

    `own`: limits by scene name.
    `for_all`: limits of `--ghostball-criteria` and of relations, or None.
    `options`: options of the command that repeats one of the tests.
    `time_limit` [s]: for a scene; None is no limit, and the engine runs in this process.
    `gate`: the baselines of the engine.
    `process`: exit stack that closes the engine's process.
    `printed`: what the engine printed in the current scene.
    """

    specs: Specs
    scenes: tuple[Scene, ...]
    own: dict[str, Criteria]
    for_all: Criteria | None
    options: tuple[str, ...]
    time_limit: float | None
    gate: Gate
    fail_on: FailOn
    process: ExitStack = field(default_factory=ExitStack)
    printed: list[str] = field(default_factory=list)

    @classmethod
    def of(cls, config: pytest.Config, picked: Sequence[str]) -> _TestPlan:
        option, project = config.option, load_config(config.invocation_params.dir)
        spec = option.ghostball_engine or _only_engine(project.engines)
        specs = Specs(spec, option.ghostball_as)
        # A named engine that doesn't exist, or can't run here, is an error.
        engine = make_engine(specs.engine)
        if specs.judged_as is not None:
            make_engine(specs.judged_as)
        known = dict.fromkeys((*engine_names(), engine.name))
        names = _asked_scenes(option.ghostball_scenes, project.scenes, picked)
        scenes = select(names)
        gate = Gate.of(spec, Path(option.ghostball_baselines or project.baselines))
        gate.check([scene.name for scene in scenes])
        own = own_criteria(scenes, criteria_beside_paths(names))
        for name, criteria in own.items():
            criteria.check_engines(known, f'limits of scene "{name}"')
        for_all = None
        if (file := option.ghostball_criteria) is not None:
            for_all = Criteria.load(file)
            for_all.check_engines(known, file)
            if for_all.truth is not None:
                raise GhostballError(
                    f"{file}: `truth` must be left out, because scenes have different kinds of "
                    "reference. Remove it"
                )
        if (named := option.ghostball_relations) is not None:
            related = relation_criteria([one.strip() for one in named.split(",") if one.strip()])
            given = Criteria() if for_all is None else for_all
            rows = (*given.criteria, *related.criteria)
            for_all = Criteria(**(dict(given) | {"criteria": rows}))
        seconds = option.ghostball_time_limit
        time_limit = None if seconds == math.inf else seconds
        check_limits(1, time_limit)
        shipped = all(scene.name in scene_names() for scene in scenes)
        again = {
            "--ghostball-engine": spec,
            "--ghostball-baselines": option.ghostball_baselines,
            "--ghostball-as": option.ghostball_as,
            "--ghostball-criteria": file,
            "--ghostball-scenes": None if shipped else ",".join(names),
            "--ghostball-relations": named,
            "--ghostball-time-limit": None if seconds == TIME_LIMIT else f"{seconds:g}",
        }
        options = [word for pair in again.items() if pair[1] is not None for word in pair]
        fail_on = project.fail_on
        return cls(specs, tuple(scenes), own, for_all, tuple(options), time_limit, gate, fail_on)

    def asked(self, scene: Scene) -> Requirements:
        return asked_of_engine(self.specs, self.own[scene.name], self.for_all)

    def run(self, scene: Scene, asked: Requirements) -> SceneRun:
        self.printed.clear()
        found = run_scene(
            self.specs,
            scene,
            self.own[scene.name],
            asked,
            lambda _: self._player,
            every_record=scene.name == self._first,
        )
        return replace(found, record=replace(found.record, printed="\n".join(self.printed)))

    @cached_property
    def _first(self) -> str:
        if is_ours(self.specs.engine):  # Ghostball's own tests check the shipped engines
            return ""
        return smallest_supported(make_engine(self.specs.engine), self.scenes)

    @cached_property
    def _player(self) -> ReferenceEngine:
        """The engine in its own process, one for all scenes; `process` closes it."""
        engine = make_engine(self.specs.engine)
        return self.process.enter_context(
            in_other_process(engine, self.time_limit, self.printed.append)
        )

    def commands(self, nodeid: str, scene: Scene) -> Iterator[str]:
        """Yield the command that repeats a test, and the command that explains the error."""
        yield shlex.join(["pytest", nodeid, *self.options])
        if scene.name in scene_names():
            yield shlex.join(["ghostball", "explain", scene.name, "--engine", self.specs.engine])


def _only_engine(engines: Sequence[str]) -> str:
    """Return the only engine of the project, or Ghostball's engine if it names none.

    Raises `GhostballError` if the project names several engines.
    """
    if len(engines) > 1:
        raise GhostballError(
            f"`[tool.ghostball]` names several engines: {', '.join(engines)}. Choose one with "
            "--ghostball-engine"
        )
    return engines[0] if engines else OURS


def _asked_scenes(text: str | None, project: Sequence[str], picked: Sequence[str]) -> list[str]:
    """Return names, tags and paths of the scenes, from the option, the tests, or the project."""
    if text is None:
        named = list(dict.fromkeys(pick.split("::")[1] for pick in picked))
        if named and all(named) and (not project or set(named) <= set(scene_names())):
            return named
        return [*project] or [DEFAULT_SCENES]
    return [piece.strip() for piece in text.split(",")]


class _Node(pytest.Collector):
    """Node for the tests in pytest's tree, because no file contains them."""

    def collect(self) -> Iterable[pytest.Item | pytest.Collector]:
        return ()


class _SceneNode(_Node):
    """A scene, which runs once, with the first of its tests."""

    def __init__(self, *, plan: _TestPlan, scene: Scene, **node: Any) -> None:
        super().__init__(**node)
        self.plan, self.scene = plan, scene
        self.asked = plan.asked(scene)
        self.metrics = requirement_names(plan.specs, scene, self.asked)
        if plan.gate.guards(scene.name):
            self.metrics += (BASELINE,)
        self.failure_reported = False  # whether one test has reported that the engine failed

    @cached_property
    def outcome(self) -> SceneRun:
        """The run of the scene, with its checks."""
        return self.plan.run(self.scene, self.asked)

    def collect(self) -> list[pytest.Item]:
        return [
            MetricItem.from_parent(self, name=metric, nodeid=f"{self.nodeid}::{metric}")
            for metric in self.metrics
        ]


class MetricItem(pytest.Item):
    """One metric of a scene."""

    parent: _SceneNode

    def runtest(self) -> None:
        """Pass, fail or skip the test, as the metric requires."""
        outcome = self.parent.outcome
        if self.name == COMPLETES:
            self._report_all(outcome)
            if outcome.record.printed:
                self.add_report_section("call", "engine", harmless(outcome.record.printed))
        if outcome.record.outcome == "failed":
            if self.parent.failure_reported:
                pytest.skip("the engine failed in this scene: see the first test of the scene")
            self.parent.failure_reported = True
        elif self.name == BASELINE:
            self._compare(outcome)
            return
        finding = outcome.finding(self.name)
        if finding.outcome == "skipped":
            pytest.skip(harmless(finding.words))
        if finding.outcome == "failed":
            pytest.fail(self._message(outcome, finding), pytrace=False)

    def _compare(self, outcome: SceneRun) -> None:
        """Compare the run with its baseline."""
        if outcome.motion is None:
            pytest.skip(harmless(f"there is nothing to compare: {outcome.record.reason}"))
        plan = self.parent.plan
        played = ComparedRun.of(outcome.record, outcome.motion)
        change = compare_case(played, plan.gate, time_limit=plan.time_limit, fail_on=plan.fail_on)
        words = f"{change.change}: {change.summary}"
        if change.change in UNCOMPARED:
            pytest.skip(harmless(words))
        if change.failed:
            command = regress_command(self.parent.scene.name, engine=plan.specs.engine)
            pytest.fail(harmless(f"{words}\n  more      {command}"), pytrace=False)

    def reportinfo(self) -> tuple[Path, None, str]:
        """Return file and name of the test in reports."""
        return self.path, None, f"{self.parent.scene.name}: {self.name}"

    def _report_all(self, outcome: SceneRun) -> None:
        """Store every metric as a test property, for `--junitxml` and the summary."""
        record = outcome.record
        self.user_properties += [("ghostball_scene", record.scene), ("engine", record.label)]
        self.user_properties.append((_UNJUDGED, not_judged([record])))
        self.user_properties += [
            (name, value) for name, value in record.metrics.items() if value is not None
        ]

    def _message(self, outcome: SceneRun, finding: RequirementResult) -> str:
        record = outcome.record
        lines = [finding.words, f"  scene     {record.scene}: {record.title}"]
        lines.append(f"  engine    {record.label}")
        for check in finding.checks:
            metric = METRICS[check.metric]
            lines.append(f"  measured  {metric.name}: {metric.meaning}")
            if metric.compares is not None:
                lines.append(f"  reference {record.truth}")
            lines.append(f"  limit     {check.reason}")
        commands = self.parent.plan.commands(self.nodeid, self.parent.scene)
        for what, command in zip(("again", "explain"), commands, strict=False):
            lines.append(f"  {what:<8}  {command}")
        if record.traceback:
            lines += ["", record.traceback.rstrip()]
        return harmless("\n".join(lines))
