"""The golden shots: shipped scenes and random scenes that have a reference result.

>>> shots = golden_shots()
>>> shots["bank-3"].reference, len(shots["bank-3"].events)
('proof', 3)
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import count, islice
from pathlib import Path
from typing import Final

import numpy as np

from ghostball.model import EventKind, Scene
from ghostball.model.arrays import FloatArray
from ghostball.model.result import event_dict
from ghostball.model.scene import json_schema
from ghostball.model.strokes import struck_balls
from ghostball.reference_adapters.base import resolution_of, stated_error
from ghostball.reference_adapters.certified import Certificate, CertifiedSettings, Enclosure
from ghostball.reference_adapters.certified.engine import result_of
from ghostball.reference_adapters.ghostball import GhostballEngine
from ghostball.validation.checks.criteria import common_criteria
from ghostball.validation.golden.format import (
    SCHEMA,
    SCHEMA_FILES,
    GoldenEvent,
    GoldenShot,
    Reference,
    Tolerance,
    golden_schema,
    json_values,
)
from ghostball.validation.grading.event_logs import events_of_certificate
from ghostball.validation.grading.gradable import gradable
from ghostball.validation.grading.grading import negligible_ends
from ghostball.validation.grading.horizon import extent_of, growth_along_certificate
from ghostball.validation.grading.tolerances import UNIT_ROUNDOFF
from ghostball.validation.scenes.library import BOARD, FULL, select
from ghostball.validation.scenes.random_scenes import PROVABLE, Wanted, random_scene
from ghostball.validation.truth.certificates import certificate_of
from ghostball.validation.truth.closed_forms import closed_form
from ghostball.validation.truth.integration import integrated, may_be_integrated

SHOTS_OF_FAMILY: Final = 12
"""Number of random shots of each family."""

MOST_EVENTS: Final = 200
"""Largest number of events of a golden shot."""

README: Final = Path(__file__).with_name("README.md")
"""The page that a folder of golden shots contains."""

_SIGNIFICANT: Final = 2
"""Number of digits of a tolerance: more would depend on the order of sums in matrix products."""


@dataclass(frozen=True)
class GoldenFamily:
    """Random shots of one kind.

    `kind`, `least`: a shot must have at least this number of comparable events of this kind.
    `having`: required options of `random_scene`.
    """

    kind: EventKind
    least: int
    having: Mapping[str, Wanted]


_IN_PLANE: Final[Mapping[str, Wanted]] = {**PROVABLE, "flight": "no"}

FAMILIES: Final[Mapping[str, GoldenFamily]] = {
    "cut": GoldenFamily(EventKind.BALL_BALL, 1, {**_IN_PLANE, "count": "few", "table": "none"}),
    "bank": GoldenFamily(
        EventKind.BALL_CUSHION,
        1,
        {**_IN_PLANE, "count": "one", "table": ("pool", "small", "narrow")},
    ),
    "spin": GoldenFamily(
        EventKind.BALL_BALL,
        1,
        {
            **_IN_PLANE,
            "count": "few",
            "motion": "sliding",
            "spin": ("across", "vertical"),
            "table": ("pool", "open"),
        },
    ),
    "break": GoldenFamily(
        EventKind.BALL_BALL, 5, {**_IN_PLANE, "count": "many", "layout": "loose-rack"}
    ),
    "pocket": GoldenFamily(EventKind.POCKETED, 1, {**_IN_PLANE, "table": "pockets"}),
    "stroke": GoldenFamily(EventKind.BALL_BALL, 1, {**_IN_PLANE, "spin": "struck"}),
    "flight": GoldenFamily(
        EventKind.BALL_CLOTH,
        1,
        {**PROVABLE, "motion": "sliding", "flight": ("low", "jump", "drop")},
    ),
}
"""The families of random shots by name; the shots are called "cut-3", with the scene's number."""


def golden_shots() -> dict[str, GoldenShot]:
    """Return all golden shots by name."""
    shipped = (golden_shot(scene) for scene in select([FULL, BOARD]))
    shots = [shot for shot in shipped if shot is not None]
    for name, family in FAMILIES.items():
        shots += islice(_random_shots(name, family), SHOTS_OF_FAMILY)
    return {shot.scene.name: shot for shot in shots}


def golden_files() -> dict[str, str]:
    """Return the content of each file of a folder of golden shots: shots, schemas and a README."""
    files = {
        f"{name}.json": json.dumps(shot.to_values(), indent=1) + "\n"
        for name, shot in golden_shots().items()
    }
    schemas = zip(SCHEMA_FILES, (golden_schema(), json_schema()), strict=True)
    files |= {name: text + "\n" for name, text in schemas}
    return files | {README.name: README.read_text(encoding="utf-8")}


def _random_shots(name: str, family: GoldenFamily) -> Iterator[GoldenShot]:
    for number in count():
        scene = random_scene(number, **family.having)
        named = {"name": f"{name}-{number}", "title": f"Random {name} {number}"}
        scene = Scene.model_validate(scene.model_dump(by_alias=True) | named)
        shot = golden_shot(scene)
        if shot is None:
            continue
        if sum(event.kind == family.kind.label for event in shot.events) >= family.least:
            yield shot


def golden_shot(scene: Scene) -> GoldenShot | None:
    """Return the golden shot of a scene, if there is one.

    None if no event or rest position can be compared, or if it has more than `MOST_EVENTS` events.
    """
    values = json_values(scene)
    plain = Scene.model_validate(values)
    known, kind, error = _reference_of(plain)
    if known is None or len(known.events) > MOST_EVENTS:
        return None
    within, growth = gradable(plain, known), growth_along_certificate(plain, known)
    assert within.sizes is not None
    shifts = growth.rounding(plain).events
    logged = result_of(plain, known, CertifiedSettings(), "events").events
    assert logged is not None
    log = events_of_certificate(known)
    negligible = negligible_ends(plain, log)
    per_time, per_place = (
        _limit(metric) * UNIT_ROUNDOFF for metric in ("event_time_factor", "quality_factor")
    )
    if kind == "integration":  # no engine computes this motion to rounding
        stated = stated_error(resolution_of(GhostballEngine(), plain))
        per_time, per_place = per_time + stated, per_place + stated
    events, tolerances, until = [], [], within.until
    for k, (event, drop) in enumerate(zip(log, negligible, strict=True)):
        if event.t > until or not np.isfinite(shifts[k]):
            until = min(until, event.t)
            break
        if not drop:
            enclosure = known.events[k].t
            events.append(GoldenEvent(**event_dict(logged[k])))
            tolerances.append(_rounded_up(_wrong_by(enclosure) + error + per_time * shifts[k]))
    sizes = np.maximum(within.sizes, extent_of(plain))
    whole = within.extent == "whole" and until == math.inf and bool(np.all(np.isfinite(sizes)))
    rest, of_rest = None, None
    if whole:
        of_rest = tuple(
            _rounded_up(max(map(_wrong_by, place)) + error + per_place * size)
            for place, size in zip(known.positions, sizes.tolist(), strict=True)
        )
        rest = result_of(plain, known, CertifiedSettings(), "rest").rest_positions
        rest, kind = _of_closed_form(scene, rest, kind)
    elif not events:
        return None
    return GoldenShot(
        schema=SCHEMA,
        reference=kind,
        valid_until=None if whole else events[-1].t,
        scene=plain,
        strikes=tuple(one.to_dict() for one in struck_balls(scene)),
        events=tuple(events),
        rest_positions=None if rest is None else tuple(map(tuple, rest.tolist())),
        tolerance=Tolerance(events=tuple(tolerances), rest_positions=of_rest),
    )


def _reference_of(scene: Scene) -> tuple[Certificate | None, Reference, float]:
    """Return the certificate or the integration of a shot, its kind, and its error [m], [s]."""
    certificate, _ = certificate_of(scene)
    if certificate is not None and certificate.proved:
        return certificate, "proof", 0.0
    if may_be_integrated(scene):
        integration, _ = integrated(scene)
        if integration is not None:
            return integration.shot, "integration", integration.error
    return certificate, "proof", 0.0


def _of_closed_form(
    scene: Scene, rest: FloatArray, kind: Reference
) -> tuple[FloatArray, Reference]:
    """Return the rest positions by the closed form of a scene, if it has one, and their kind."""
    form = closed_form(scene)
    if form is None:
        return rest, kind
    rest = rest.copy()
    rest[:, :2] = np.array(form.rest_positions, dtype=object).astype(np.float64)[:, :2]
    return rest, "closed form"


def _limit(metric: str) -> float:
    """Return the common limit on errors of an engine that errs by rounding alone, in roundings."""
    (limit,) = (
        one.at_most
        for one in common_criteria().criteria
        if one.metric == metric and one.claiming == "rounding"
    )
    assert isinstance(limit, (int, float))
    return float(limit)


def _wrong_by(number: Enclosure) -> float:
    """Return the largest error of the double that is nearest to the middle of an enclosure."""
    return float(abs(Fraction(float(number)) - number.mid) + number.rad)


def _rounded_up(value: float) -> float:
    """Return a tolerance with `_SIGNIFICANT` digits, no smaller than the value."""
    power = 10.0 ** (math.floor(math.log10(value)) - _SIGNIFICANT + 1)
    return float(f"{math.ceil(value / power) * power:.{_SIGNIFICANT - 1}e}")
