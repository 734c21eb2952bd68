"""Hints printed after a run: untested features, what the failures have in common, the next command.

A run passes if nothing it tested is wrong. An engine that squares the restitution passes every
scene with elastic balls. A run therefore also lists the features that the engine claims but no
scene tested, and the scenes that test them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import cache, partial

from ghostball.model import EventKind, Scene
from ghostball.model.features import Feature, has_feature, missing_features, scene_features
from ghostball.model.impact_laws import BALL_LAWS, CUSHION_LAWS
from ghostball.reference_adapters.base import ReferenceEngine
from ghostball.validation.checks.verdict import Verdict, verdict_of
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.scenes.library import find_scene, select

BALL_BALL, CUSHION = EventKind.BALL_BALL.label, EventKind.BALL_CUSHION.label

FEWEST_BAD = 2
"""Number of bad cases from which a common property is reported."""


LARGEST_GOOD_SHARE = 1.0 / 3.0
"""Largest share of the good cases that may have the property that all bad cases share."""


SCENES_OF_FEATURE: Mapping[Feature, tuple[str, ...]] = {
    Feature.ROLLING: ("head-on",),
    Feature.SLIDING: ("sliding-stun",),
    Feature.FRICTIONLESS_CLOTH: ("cloth-frictionless", "cloth-frictionless-sliding"),
    Feature.VERTICAL_SPIN: ("side-spin",),
    Feature.BALL_RESTITUTION: ("restitution-head-on", "restitution-sliding"),
    Feature.BALL_FRICTION: ("throw-slip",),
    Feature.SPEED_DEPENDENT_FRICTION: ("throw-alciatore",),
    Feature.MATHAVAN_BALL: ("ball-mathavan",),
    Feature.UNEQUAL_MASSES: ("unequal-masses", "unequal-masses-sliding"),
    Feature.UNEQUAL_RADII: ("unequal-radii", "unequal-radii-sliding"),
    Feature.PER_BALL_FRICTION: ("ball-frictions", "ball-frictions-rolling"),
    Feature.UNBOUNDED_CLOTH: ("unbounded-cut", "unbounded-sliding"),
    Feature.OPEN_SIDES: ("open-sides", "open-sides-sliding"),
    Feature.POLYGON: ("polygon-bounce", "polygon-sliding"),
    Feature.POCKETS: ("pocket-jaw", "pocket-sliding"),
    Feature.POSTS: ("post-bounce", "post-sliding"),
    Feature.MIRROR_CUSHION: ("wall-bounce", "wall-bounce-sliding"),
    Feature.CUSHION_RESTITUTION: ("cushion-restitution", "cushion-restitution-sliding"),
    Feature.FALLING_RESTITUTION: ("cushion-falling", "cushion-falling-sliding"),
    Feature.CUSHION_TANGENTIAL: ("cushion-tangential", "cushion-tangential-sliding"),
    Feature.FRICTIONAL_CUSHION: ("cushion-frictional",),
    Feature.HAN_CUSHION: ("cushion-han",),
    Feature.MATHAVAN_CUSHION: ("cushion-mathavan",),
    Feature.STRONGE_CUSHION: ("cushion-stronge",),
    Feature.AIR_DRAG: ("air-drag", "air-drag-sliding"),
    Feature.QUADRATIC_ROLLING: ("cloth-quadratic", "cloth-quadratic-sliding"),
    Feature.FLIGHT: ("flight-lands",),
    Feature.COMPLIANT: ("compliant-row", "compliant-row-sliding"),
}
"""Shipped scenes that test each feature alone, or with only the features that it needs.

Two scenes if both rolling and sliding balls can have the feature: an engine may support only one of
them.
"""

_CUSHION_FEATURES = {Feature[law.feature] for law in CUSHION_LAWS if law.feature} | {
    Feature.FALLING_RESTITUTION,
    Feature.CUSHION_TANGENTIAL,
    Feature.OPEN_SIDES,
    Feature.POLYGON,
    Feature.POSTS,
}
_BALL_PAIR_FEATURES = {Feature[law.feature] for law in BALL_LAWS if law.feature} | {
    Feature.BALL_RESTITUTION,
    Feature.BALL_FRICTION,
    Feature.SPEED_DEPENDENT_FRICTION,
    Feature.UNEQUAL_MASSES,
    Feature.UNEQUAL_RADII,
    Feature.COMPLIANT,
}


def features_tested(case: CaseRecord) -> set[Feature]:
    """Return the features that a case tested; those of cushions only if a ball hit a cushion."""
    if case.outcome != "ran":
        return set()
    tried = set(scene_features(case.load_scene()))
    tried -= set() if _happened(case, CUSHION) else _CUSHION_FEATURES
    return tried - (set() if _happened(case, BALL_BALL) else _BALL_PAIR_FEATURES)


def untested_features(engine: ReferenceEngine, tried: Collection[Feature]) -> Mapping[Feature, str]:
    """Return the features that an engine claims but no case tested.

    The value is the name of a shipped scene that tests the feature and that the engine supports: a
    scene with this feature alone, otherwise the simplest one; "" if there is none.
    """
    claimed = [one for one in Feature if has_feature(engine.capabilities, one)]
    return {one: _trying(one, engine) for one in claimed if one not in tried}


def _trying(feature: Feature, engine: ReferenceEngine) -> str:
    def is_able(scene: Scene) -> bool:
        return not missing_features(engine.capabilities, scene)

    able = next(filter(is_able, map(find_scene, SCENES_OF_FEATURE[feature])), None)
    if able is None:
        having = (one for one in _by_size() if feature in scene_features(one))
        able = next(filter(is_able, having), None)
    return "" if able is None else able.name


@cache
def _by_size() -> tuple[Scene, ...]:
    """Return the shipped scenes, the simplest first."""
    return tuple(sorted(select(), key=_size))


def _size(scene: Scene) -> tuple[int, int, str]:
    return len(scene_features(scene)), len(scene.balls), scene.name


def unsupported_features(cases: Sequence[CaseRecord]) -> Mapping[str, int]:
    """Return the features that an engine lacks, with the number of unsupported scenes for each."""
    unable = [case for case in cases if verdict_of(case) is Verdict.NOT_REPRESENTABLE]
    counts = Counter(
        one.removeprefix("no ") for case in unable for one in dict.fromkeys(_sentences(case))
    )
    return dict(counts.most_common())


def _sentences(case: CaseRecord) -> list[str]:
    return [one.partition(" (")[0] for one in case.reason.split("; ")]


def simplest(cases: Sequence[CaseRecord]) -> CaseRecord | None:
    """Return the case that is easiest to investigate: fewest balls, features and collisions."""
    return min(cases, key=_simplicity, default=None)


def _simplicity(case: CaseRecord) -> tuple[int, int, int, str]:
    scene, collisions = case.load_scene(), sum((case.truth_counts or {}).values())
    return len(scene.balls), len(scene_features(scene)), collisions, case.scene


def shared(bad: Sequence[CaseRecord], good: Sequence[CaseRecord]) -> str:
    """Return a property of all bad cases and few good cases, such as "ball collisions".

    Returns "" if no property separates them. Of several such properties, the one that
    the fewest good cases have is returned.
    """
    if len(bad) < FEWEST_BAD or not good:
        return ""
    having = {name: sum(map(has, good)) for name, has in _traits() if all(map(has, bad))}
    if not having:
        return ""
    name = min(having, key=having.__getitem__)
    if having[name] > LARGEST_GOOD_SHARE * len(good):
        return ""
    count = having[name]
    rest = f"{count} of the other {len(good)} scenes" if count else "no other scene"
    return f"all {len(bad)} have {name}; {rest} {'does' if count < 2 else 'do'}"


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
