"""The first of the suite's five verbs: plan what is run, and what each case is asked.

A scene's way through a run is `plan` here, run (`validation.suite.case`: its truth here, once for
all engines, each engine in another process), `judge` (`validation.suite.judge`, there too), store
(`validation.results.store`) and report (`reports`), each once, in this order. Planning solves,
proves, compiles and plays nothing.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ghostball.model import Scene
from ghostball.reference_adapters.registry import (
    EngineUnavailableError,
    engine_name,
    engine_names,
    make_engine,
)
from ghostball.validation.checks.criteria import Criteria, criteria_beside
from ghostball.validation.checks.law import Asked, asked_of
from ghostball.validation.checks.metrics import METRICS, choose_metrics
from ghostball.validation.parallel.sources import is_ours
from ghostball.validation.results.environment import describe_environment
from ghostball.validation.results.record_store import Name
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.runs.playing import first_played
from ghostball.validation.runs.runner import check_each_once
from ghostball.validation.scenes.library import find_scene, paths_among, scene_names, scene_path
from ghostball.validation.suite.unchanged import inputs_hash, measured_between
from ghostball.validation.suite.varied import Ensemble
from ghostball.validation.truth.scene_truth import check_truth


@dataclass(frozen=True, eq=False)
class Plan:
    """A run, checked: what will be run and against which criteria."""

    scenes: Sequence[Scene]
    settings: Mapping[str, dict[str, Any] | None]  # by label; None: the engine is unavailable
    criteria: Mapping[str, Criteria]  # by scene name
    given: frozenset[str]  # scenes whose criteria were given, not shipped
    asked: Mapping[Name, Asked]  # by scene name and label
    inputs: Mapping[Name, str]  # hashes; "": always run
    metrics: tuple[str, ...] | None  # None: all
    origins: Mapping[str, str]  # of varied starts, by their names
    firsts: Mapping[str, str]  # by label, the scene that is played with less recorded too
    keeps_motion: bool = True

    @property
    def size(self) -> int:
        """How many cases there are."""
        return len(self.inputs)

    def describe(self, reused: Mapping[Name, CaseRecord]) -> dict[str, Any]:
        """Return what the results say of the run, of which an earlier one did this much."""
        return describe_environment() | {
            "scenes": [scene.name for scene in self.scenes if scene.name not in self.origins],
            "engines": list(self.settings),
            "engine_settings": dict(self.settings),
            "metrics": list(self.metrics or METRICS),
            "planned": self.size,
            "reused": measured_between(reused.values()),
        }

    def scenes_of(self, pairs: Sequence[Name]) -> list[Scene]:
        """Return the scenes that these cases need, each once."""
        names = {name for name, _ in pairs}
        return [scene for scene in self.scenes if scene.name in names]


def plan(
    scenes: Sequence[Scene],
    labels: Sequence[str],
    criteria: Mapping[str, Criteria],
    metrics: Sequence[str] | None,
    only: Collection[Name] | None = None,
    ensemble: Ensemble | None = None,
    keeps_motion: bool = True,
) -> Plan:
    """Return what is run and what is asked of it; refuse what is wrong before anything runs.

    One error comes later, from `prepare`: criteria ask for a closed form that the scene lacks. Only
    solving the shot shows this.

    Raises `GhostballError` see `validation.suite.suite.run_suite`.
    """
    chosen = None if metrics is None else choose_metrics(metrics)
    check_each_once("scene", [scene.name for scene in scenes])
    check_each_once("engine", labels)
    origins: dict[str, str] = {}
    if ensemble is not None:
        starts = {scene.name: ensemble.of(scene) for scene in scenes}
        origins = {one.name: origin for origin, these in starts.items() for one in these}
        scenes = [*scenes, *(one for these in starts.values() for one in these)]
        check_each_once("scene", [scene.name for scene in scenes])
    settings = {label: _settings_of(label) for label in labels}
    own = {
        scene.name: criteria[scene.name] if scene.name in criteria else shipped_criteria(scene)
        for scene in scenes
    }
    names = {label: engine_name(label) for label in labels}
    known = tuple(dict.fromkeys((*engine_names(), *names.values())))
    for scene in scenes:
        own[scene.name].check_engines(known, f'limits of scene "{scene.name}"')
        if scene.name in criteria:  # the shipped ones are checked as their truth is computed
            check_truth(scene, own[scene.name].truth)
    of_others = tuple(e for e, values in settings.items() if values is not None and not is_ours(e))
    firsts: dict[str, str] = {}  # our tests ask that of the engines that are shipped
    for label in of_others:
        given = [one for one in scenes if only is None or (one.name, label) in only]
        mine = [one for one in given if one.name not in origins]
        firsts[label] = first_played(make_engine(label), mine)
    asked: dict[Name, Asked] = {}
    inputs: dict[Name, str] = {}
    for scene in scenes:
        for label, values in settings.items():
            pair, limits = (scene.name, label), own[scene.name]
            if only is not None and pair not in only:
                continue
            asked[pair] = Asked() if values is None else asked_of([(names[label], values)], limits)
            inputs[pair] = (
                ""
                if values is None or label in of_others
                else inputs_hash(scene, label, values, asked[pair], limits.truth, chosen)
            )
    named = frozenset(criteria)
    return Plan(scenes, settings, own, named, asked, inputs, chosen, origins, firsts, keeps_motion)


def shipped_criteria(scene: Scene) -> Criteria:
    """Return the criteria of the shipped scene that `scene` is; none where it is no shipped one.

    A scene that shares its name with a shipped one but differs in a value has none: the numbers
    were chosen for the shipped values.

    Raises `CriteriaError` where its criteria file is refused.
    """
    if scene.name not in scene_names() or find_scene(scene.name) != scene:
        return Criteria()
    return criteria_beside(scene_path(scene.name))


def criteria_beside_paths(names_or_tags: Sequence[str]) -> dict[str, Criteria]:
    """Return the criteria of the scenes that are given by path, by scene name.

    `names_or_tags`: what `select` was asked for; names and tags are passed over.

    Raises `GhostballError` where such a scene or the criteria beside it are refused.
    """
    return {find_scene(path).name: criteria_beside(path) for path in paths_among(names_or_tags)}


def _settings_of(label: str) -> dict[str, Any] | None:
    """Return all settings of the engine that `label` names, or None where it can't run here."""
    try:
        return make_engine(label).settings.model_dump(mode="json")
    except EngineUnavailableError:
        return None
