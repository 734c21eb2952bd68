"""What a run says beyond its verdicts: what it never tried, what its failures share, what is next.

A run passes where nothing that it tried is wrong. An engine that squares restitution passes all
scenes in which balls are elastic: so a run also says which features an engine claims that none of
its scenes has, and which scenes have them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import partial

from ghostball.model import EventKind, Scene
from ghostball.model.features import Feature, has_feature, missing_features, scene_features
from ghostball.reference_adapters.base import ReferenceEngine
from ghostball.validation.checks.verdict import Verdict, verdict_of
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.scenes.library import find_scene, select

BALL_BALL, CUSHION = EventKind.BALL_BALL.label, EventKind.BALL_CUSHION.label

FEWEST_ALIKE = 2
"""Cases that must be bad, before something is said of what they share."""


FEW = 1.0 / 3.0
"""Largest share of the others that may have a trait, too, which still tells the bad ones apart."""


ALONE: Mapping[Feature, str] = {
    Feature.ROLLING: "head-on",
    Feature.SLIDING: "sliding-stun",
    Feature.FRICTIONLESS_CLOTH: "cloth-frictionless",
    Feature.VERTICAL_SPIN: "side-spin",
    Feature.BALL_RESTITUTION: "restitution-head-on",
    Feature.BALL_FRICTION: "throw-slip",
    Feature.SPEED_DEPENDENT_FRICTION: "throw-alciatore",
    Feature.MATHAVAN_BALL: "ball-mathavan",
    Feature.UNEQUAL_MASSES: "unequal-masses",
    Feature.UNEQUAL_RADII: "unequal-radii",
    Feature.PER_BALL_FRICTION: "ball-frictions",
    Feature.UNBOUNDED_CLOTH: "unbounded-cut",
    Feature.OPEN_SIDES: "open-sides",
    Feature.POLYGON: "polygon-bounce",
    Feature.POCKETS: "pocket-jaw",
    Feature.POSTS: "post-bounce",
    Feature.MIRROR_CUSHION: "wall-bounce",
    Feature.CUSHION_RESTITUTION: "cushion-restitution",
    Feature.FALLING_RESTITUTION: "cushion-falling",
    Feature.CUSHION_TANGENTIAL: "cushion-tangential",
    Feature.FRICTIONAL_CUSHION: "cushion-frictional",
    Feature.HAN_CUSHION: "cushion-han",
    Feature.MATHAVAN_CUSHION: "cushion-mathavan",
    Feature.AIR_DRAG: "air-drag",
    Feature.QUADRATIC_ROLLING: "cloth-quadratic",
    Feature.FLIGHT: "flight-lands",
}
"""The shipped scene that tries each feature alone, or with just what the feature itself needs."""


def untried(engine: ReferenceEngine, tried: Collection[Scene]) -> Mapping[Feature, str]:
    """Return what an engine claims and these scenes, as far as it can play them, don't try.

    By feature: the name of a shipped scene that tries it, and that the engine can play: the one
    that tries it alone, else the simplest; "" where there is none.
    """
    seen = {
        feature
        for scene in tried
        if not missing_features(engine.capabilities, scene)
        for feature in scene_features(scene)
    }
    claimed = [one for one in Feature if has_feature(engine.capabilities, one) and one not in seen]
    return {one: _trying(one, engine) for one in claimed}


def _trying(feature: Feature, engine: ReferenceEngine) -> str:
    alone = find_scene(ALONE[feature])
    for scene in (alone, *sorted(select(), key=_size)):
        able = not missing_features(engine.capabilities, scene)
        if able and feature in scene_features(scene):
            return scene.name
    return ""


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
