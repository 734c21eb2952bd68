"""What a run says beyond its verdicts: what it never tried, what its failures share, what is next.

A run passes where nothing that it tried is wrong. An engine that squares restitution passes all
scenes in which balls are elastic: so a run also says which features an engine claims that none of
its scenes has, and which scenes have them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from ghostball.model import EventKind, Scene
from ghostball.model.features import Feature, has_feature, missing_features, scene_features
from ghostball.reference_adapters.base import ReferenceEngine
from ghostball.validation.checks.verdict import Verdict, verdict_of
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.scenes.library import select

BALL_BALL, CUSHION = EventKind.BALL_BALL.label, EventKind.BALL_CUSHION.label

FEWEST_ALIKE = 2
"""Cases that must be bad, before something is said of what they share."""


FEW = 1.0 / 3.0
"""Largest share of the others that may have a trait, too, which still tells the bad ones apart."""


@dataclass(frozen=True)
class Untried:
    """Features that an engine claims, and no scene of a run has.

    `scenes`: shipped ones that it can play and that have them, the simplest of each.
    """

    features: tuple[Feature, ...]
    scenes: tuple[str, ...]


def untried(engine: ReferenceEngine, tried: Collection[Scene]) -> Untried:
    """Return what an engine claims and these scenes, as far as it can play them, don't try."""
    claimed = [one for one in Feature if has_feature(engine.capabilities, one)]
    seen = {
        feature
        for scene in tried
        if not missing_features(engine.capabilities, scene)
        for feature in scene_features(scene)
    }
    features = tuple(one for one in claimed if one not in seen)
    simplest: dict[Feature, Scene] = {}
    for scene in sorted(select(), key=_size) if features else ():
        if not missing_features(engine.capabilities, scene):
            for feature in scene_features(scene):
                simplest.setdefault(feature, scene)
    found = dict.fromkeys(simplest[one].name for one in features if one in simplest)
    return Untried(features, tuple(found))


def _size(scene: Scene) -> tuple[int, int, str]:
    return len(scene_features(scene)), len(scene.balls), scene.name


def lacked(cases: Sequence[CaseRecord]) -> Mapping[str, int]:
    """Return what an engine lacked in the scenes that it can't play, and in how many of them."""
    unable = [case for case in cases if verdict_of(case) is Verdict.NOT_REPRESENTABLE]
    counts = Counter(
        one.removeprefix("no ") for case in unable for one in dict.fromkeys(_sentences(case))
    )
    return dict(counts.most_common())


def _sentences(case: CaseRecord) -> list[str]:
    return [one.partition(" (")[0] for one in case.reason.split("; ")]


def simplest(cases: Sequence[CaseRecord]) -> CaseRecord | None:
    """Return the case that is the easiest to look into: fewest balls, features and collisions."""
    return min(cases, key=_simplicity, default=None)


def _simplicity(case: CaseRecord) -> tuple[int, int, int, str]:
    scene, collisions = case.load_scene(), sum((case.truth_counts or {}).values())
    return len(scene.balls), len(scene_features(scene)), collisions, case.scene


def shared(bad: Sequence[CaseRecord], good: Sequence[CaseRecord]) -> str:
    """Return what cases share that are bad, or moved, and others lack: "ball collisions".

    "" where nothing tells them apart. Of what is shared by all that are bad, it is what the fewest
    others have.
    """
    if len(bad) < FEWEST_ALIKE or not good:
        return ""
    having = {name: sum(map(has, good)) for name, has in _traits() if all(map(has, bad))}
    if not having:
        return ""
    name = min(having, key=having.__getitem__)
    if having[name] > FEW * len(good):
        return ""
    rest = f"{having[name]} of the {len(good)} others" if having[name] else "no other"
    return f"all {len(bad)} have {name}, and {rest} has"


def _traits() -> Iterator[tuple[str, Callable[[CaseRecord], bool]]]:
    yield "ball collisions", lambda case: _happened(case, BALL_BALL)
    yield "cushion collisions", lambda case: _happened(case, CUSHION)
    yield "more than one ball", lambda case: len(case.definition["balls"]) > 1
    for feature in Feature:
        yield feature.value, partial(_needs, feature)


def _needs(feature: Feature, case: CaseRecord) -> bool:
    return feature in scene_features(case.load_scene())


def _happened(case: CaseRecord, kind: str) -> bool:
    counts = case.collision_counts if case.truth_counts is None else case.truth_counts
    return counts.get(kind, 0) > 0
