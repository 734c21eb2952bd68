"""Plan a run and the limits of each case: step one of the five steps of a run.

The steps are: `plan` (here); run (`validation.suite.case`: the reference result in this process,
once for all engines; each engine, in another process if there are several jobs or a time limit);
`judge` (`validation.suite.judge`, in the same process as the engine); store
(`validation.results.store`); and report (`reports`). Each step happens once, in this order.
Planning doesn't solve, certify, compile or simulate anything.
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
from ghostball.validation.checks.criteria import Criteria, criteria_beside, relation_criteria
from ghostball.validation.checks.metrics import METRICS, choose_metrics
from ghostball.validation.checks.requirements import Requirements, asked_of
from ghostball.validation.parallel.sources import is_ours
from ghostball.validation.results.environment import describe_environment
from ghostball.validation.results.record_store import Name
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.runs.engine_runs import smallest_supported
from ghostball.validation.runs.runner import check_each_once
from ghostball.validation.scenes.library import find_scene, paths_among, scene_names, scene_path
from ghostball.validation.suite.ensemble import Ensemble
from ghostball.validation.suite.unchanged import inputs_hash, measured_between
from ghostball.validation.truth.scene_truth import check_truth


@dataclass(frozen=True, eq=False)
class SuitePlan:
    """A checked run: the scenes, the engines and the criteria."""

    scenes: Sequence[Scene]
    settings: Mapping[str, dict[str, Any] | None]  # by label; None: the engine is unavailable
    criteria: Mapping[str, Criteria]  # by scene name
    given: frozenset[str]  # scenes whose criteria were given, not shipped
    asked: Mapping[Name, Requirements]  # by scene name and label
    inputs: Mapping[Name, str]  # hashes; "": can't be reused
    metrics: tuple[str, ...] | None  # None: the usual ones, and those with a limit
    # names of perturbed scenes: the name of the scene they came from
    origins: Mapping[str, str]
    firsts: Mapping[str, str]  # by label, the scene that is also run with less recorded
    keeps_motion: bool = True

    @property
    def size(self) -> int:
        """Number of cases."""
        return len(self.inputs)

    def describe(self, reused: Mapping[Name, CaseRecord]) -> dict[str, Any]:
        """Return the description of the run for its results; `reused` are earlier cases."""
        return describe_environment() | {
            "scenes": [scene.name for scene in self.scenes if scene.name not in self.origins],
            "engines": list(self.settings),
            "engine_settings": dict(self.settings),
            "metrics": list(self.metrics or METRICS),
            "planned": self.size,
            "reused": measured_between(reused.values()),
        }

    def scenes_of(self, pairs: Sequence[Name]) -> list[Scene]:
        """Return the scenes that these cases need, without duplicates."""
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
    relations: Sequence[str] | None = None,
) -> SuitePlan:
    """Return what will run and the limits that apply; refuse invalid input before anything runs.

    One error comes later, from `prepare`: criteria that ask for a closed form which the scene
    doesn't have. Only solving the shot shows this.

    Raises `GhostballError`: see `validation.suite.suite.run_suite`.
    """
    related = None if relations is None else relation_criteria(relations)
    chosen = None
    if metrics is not None:
        more = () if related is None else (one.metric for one in related.criteria)
        chosen = choose_metrics([*metrics, *more])
    check_each_once("scene", [scene.name for scene in scenes])
    check_each_once("engine", labels)
    origins: dict[str, str] = {}
    if ensemble is not None:
        starts = {scene.name: ensemble.of(scene) for scene in scenes}
        origins = {one.name: origin for origin, these in starts.items() for one in these}
        scenes = [*scenes, *(one for these in starts.values() for one in these)]
        check_each_once("scene", [scene.name for scene in scenes])
    settings = {label: _settings_of(label) for label in labels}
    own = own_criteria(scenes, criteria)
    names = {label: engine_name(label) for label in labels}
    known = tuple(dict.fromkeys((*engine_names(), *names.values())))
    for scene in scenes:
        own[scene.name].check_engines(known, f'limits of scene "{scene.name}"')
        # shipped criteria are checked when the reference result is computed
        if scene.name in criteria:
            check_truth(scene, own[scene.name].truth)
    of_others = tuple(e for e, values in settings.items() if values is not None and not is_ours(e))
    firsts: dict[str, str] = {}  # not for shipped engines: the tests of Ghostball check those
    for label in of_others:
        given = [one for one in scenes if only is None or (one.name, label) in only]
        mine = [one for one in given if one.name not in origins]
        firsts[label] = smallest_supported(make_engine(label), mine)
    asked: dict[Name, Requirements] = {}
    inputs: dict[Name, str] = {}
    for scene in scenes:
        for label, values in settings.items():
            pair, limits = (scene.name, label), own[scene.name]
            if only is not None and pair not in only:
                continue
            for_all = None if scene.name in origins else related
            asked[pair] = (
                Requirements()
                if values is None
                else asked_of([(names[label], values)], limits, for_all)
            )
            inputs[pair] = (
                ""
                if values is None or label in of_others
                else inputs_hash(scene, label, values, asked[pair], limits.truth, chosen)
            )
    named = frozenset(criteria)
    return SuitePlan(
        scenes, settings, own, named, asked, inputs, chosen, origins, firsts, keeps_motion
    )


def shipped_criteria(scene: Scene) -> Criteria:
    """Return the criteria of a shipped scene; empty if `scene` isn't a shipped one.

    A scene with the name of a shipped one but a different value has no criteria, because the limits
    were chosen for the shipped values.

    Raises `CriteriaError` if the criteria file is invalid.
    """
    if scene.name not in scene_names() or find_scene(scene.name) != scene:
        return Criteria()
    return criteria_beside(scene_path(scene.name))


def own_criteria(scenes: Sequence[Scene], given: Mapping[str, Criteria]) -> dict[str, Criteria]:
    """Return the criteria of each scene by its name: the given ones, else the shipped ones."""
    return {
        scene.name: given[scene.name] if scene.name in given else shipped_criteria(scene)
        for scene in scenes
    }


def criteria_beside_paths(names_or_tags: Sequence[str]) -> dict[str, Criteria]:
    """Return the criteria of the scenes that are given by path, by scene name.

    `names_or_tags`: the arguments of `select`; names and tags are ignored.

    Raises `GhostballError` if such a scene, or its criteria file, is invalid.
    """
    return {find_scene(path).name: criteria_beside(path) for path in paths_among(names_or_tags)}


def _settings_of(label: str) -> dict[str, Any] | None:
    """Return all settings of the engine `label`, or None if it can't run here."""
    try:
        return make_engine(label).settings.model_dump(mode="json")
    except EngineUnavailableError:
        return None
