"""The reference result of a scene, and which parts are independent of Ghostball's engine.

It is the closed form if the scene has one; otherwise the certified result if the whole shot is
certified; otherwise an integration if the scene asks for one, because a ball slides in air;
otherwise the result of Ghostball's engine. A closed form gives final positions, the end time and
the order of collisions. The energy curve and the times of collisions then come from the certified
result or the integration, if there is one; otherwise from Ghostball's engine, so that these parts
aren't independent.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, Literal, get_args

import mpmath
import numpy as np

from ghostball.model import (
    EventKind,
    GhostballError,
    Result,
    Scene,
    UnsupportedSceneError,
    partner_index,
)
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.base import Resolution, stated_error
from ghostball.reference_adapters.certified import Certificate, CertifiedSettings
from ghostball.reference_adapters.certified.engine import result_of
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.grading.certified_growth import RoundingEffects, growth_of_certificate
from ghostball.validation.grading.certified_widths import is_differentiated
from ghostball.validation.grading.event_logs import Key, collisions_of, lower_first
from ghostball.validation.grading.gradable import Gradable, gradable, motion_of_certificate
from ghostball.validation.grading.horizon import (
    Meetings,
    growth_along,
    growth_along_certificate,
    horizon,
    meetings_of,
)
from ghostball.validation.grading.lateness import Lateness, lateness_of
from ghostball.validation.grading.tolerances import ROUNDINGS, TOLERANCE, UNIT_ROUNDOFF
from ghostball.validation.results.records import CERTIFIED, CLOSED_FORM, INTEGRATION, OUR_ENGINE
from ghostball.validation.runs.engine_runs import run_ours
from ghostball.validation.runs.sampling import events_of
from ghostball.validation.truth.certificates import certificate_of, refused_features
from ghostball.validation.truth.closed_forms import (
    DIGITS,
    ClosedForm,
    closed_form,
    has_closed_form,
    may_have_closed_form,
)
from ghostball.validation.truth.integration import integrated, may_be_integrated

TruthPart = Literal["rest", "time", "events", "energy", "conditioning", "certificate"]
"""Parts of a reference that a metric may need; "certificate" is the certified part of the shot."""

WantedTruth = Literal["closed-form", "certified", "integration", "engine", "none"]
"""Kinds of reference that criteria may ask for; "none": no limit of the scene needs a reference."""

PARTS: frozenset[TruthPart] = frozenset(get_args(TruthPart))

_NO_TIMES: FloatArray = np.empty(0)


class TruthError(GhostballError):
    """A scene whose criteria ask for a reference that it doesn't have."""


@dataclass(frozen=True, eq=False)
class Truth:
    """The reference of one scene, in plain arrays, which can be sent to worker processes.

    `kind`: None if there is no reference; `missing` states why.
    `independent`: parts that don't depend on Ghostball's engine; it can be judged only by them.
    `missing`: why there is no reference, or no result of Ghostball's engine; else "".
    `rest_positions`, `rest_positions_low` (n, 3) float64 [m] or None: final positions; the exact
        value is the sum of the two, to about 2^-106.
    `rest_time`, `rest_time_low` [s]: likewise.
    `conditioning` (n,) float64 [m] or None: multiplied by 2^-52, the error of each ball that
        rounding the scene's numbers once would cause.
    `rest_time_conditioning` [s]: the same for the rest time.
    `collisions`: in order of time, the ball with the lower index first.
    `collision_times` (m,) float64 [s]: empty if a closed form gives only their order.
    `motion`: the whole shot with the reference energy: certified, else integrated, else from
        Ghostball's engine; None if there is none, or if no requested part needs it.
    `certified_shot`: the whole certified shot; None if it isn't certified to its end, or if
        "certificate" wasn't requested.
    `certificate`: of the shot or of its beginning, with the motion.
    `no_certificate`: why there is none; else "".
    `meetings`: size of errors when balls meet: from the certified shot or, if only a part is
        certified, from Ghostball's engine. None if this is unknown or wasn't requested, and for a
        closed form.
    `shot_horizon` [s]: time up to which rounding leaves the shot predictable, or up to which the
        growth of errors is known; inf: to its end, and for a closed form, whose end doesn't depend
        on rounding.
    `lateness`: effect of late detection of events on the end, or on the end of the certified part;
        None if nothing is certified, in a flight, or if "certificate" wasn't requested.
    `rounding`: effect of rounding on the times of the certified events and on the energy; None
        without a certificate, or if "certificate" wasn't requested.
    `graded`: the certified part that an exact engine is compared with; None without a certificate,
        or if "certificate" wasn't requested.
    `graded_steps`: the same for time-stepping engines: up to the horizon if the whole shot is
        certified and has no closed form; otherwise to the end.
    """

    kind: str | None
    independent: frozenset[TruthPart] = frozenset({"certificate"})
    missing: str = ""
    rest_positions: FloatArray | None = None
    rest_positions_low: FloatArray = field(default_factory=lambda: np.zeros(3))
    rest_time: float | None = None
    rest_time_low: float = 0.0
    conditioning: FloatArray | None = None
    rest_time_conditioning: float | None = None
    collisions: tuple[Key, ...] | None = None
    collision_times: FloatArray = field(default_factory=lambda: _NO_TIMES)
    collision_counts: dict[str, int] | None = None
    motion: Result | None = None
    certified_shot: Result | None = None
    certificate: Certificate | None = None
    no_certificate: str = "not requested"
    meetings: Meetings | None = None
    shot_horizon: float = math.inf
    lateness: Lateness | None = None
    rounding: RoundingEffects | None = None
    graded: Gradable | None = None
    graded_steps: Gradable | None = None

    def horizon_of(self, resolution: Resolution) -> float:
        """Return the time up to which an engine can be compared [s]; inf: to the end.

        `resolution` [m]: of the engine; see `reference_adapters.base.resolution_of`.

        With a closed form, every engine is compared up to the end, because the shot can be solved
        exactly, simultaneous collisions included. So is an engine that certifies its results. An
        engine that states no resolution is compared as long as rounding leaves the shot
        predictable: an engine gains nothing by stating no resolution.
        """
        if self.kind == CLOSED_FORM or self.meetings is None or resolution == "proved":
            return math.inf
        return self.meetings.horizon(stated_error(resolution))

    def why_not(self, part: TruthPart) -> str:
        """Return in one sentence why a part of the reference is missing."""
        if part == "conditioning":
            return "the effect of rounding is known for closed forms only"
        if part == "certificate":
            return f"not certified: {self.no_certificate}"
        return f"no reference result: {self.missing}"

    def is_own_measure(self, engine: str, part: TruthPart | None) -> bool:
        """Return True if this part would compare Ghostball's engine with itself."""
        return engine == OURS and part is not None and part not in self.independent


def check_truth(scene: Scene, wanted: WantedTruth | None) -> None:
    """Check that the fields of a scene permit the reference that its criteria ask for.

    Nothing is solved or certified here: `check_closed_form` and `truth_of` check that the reference
    exists.
    """
    if wanted == "closed-form" and not may_have_closed_form(scene):
        raise _no_closed_form(scene)
    if wanted == "certified" and (why := refused_features(scene)):
        raise TruthError(
            f'scene "{scene.name}": its criteria say `truth` = "certified", but it can\'t be '
            f'certified: {why}. Write `truth` = "engine", or "integration" if balls slide in air'
        )
    if wanted == "integration" and not may_be_integrated(scene):
        raise TruthError(
            f'scene "{scene.name}": its criteria say `truth` = "integration", but no ball slides '
            'in air, or balls may fly. Write `truth` = "certified" or "engine"'
        )


def check_closed_form(scene: Scene, wanted: WantedTruth | None) -> None:
    """Check that a scene has a closed form if its criteria ask for one; this solves it."""
    if wanted == "closed-form" and not has_closed_form(scene):
        raise _no_closed_form(scene)


def _no_closed_form(scene: Scene) -> TruthError:
    return TruthError(
        f'scene "{scene.name}": its criteria say `truth` = "closed-form", but its values have '
        'no closed form. Write `truth` = "certified" or "engine", or add the form to '
        "validation/truth/closed_forms"
    )


def truth_of(
    scene: Scene,
    wanted: WantedTruth | None = None,
    parts: Collection[TruthPart] = PARTS,
    *,
    least: int | None = 0,
    settings: CertifiedSettings | None = None,
) -> Truth:
    """Return the reference of a scene.

    `wanted`: the kind that the scene's criteria ask for; None: the first kind that exists.
    `parts`: the parts that will be needed; work for other parts may be skipped.
    `least`: number of events that must be certified, if the scene can be certified at all; None:
        all, to the end.
    `settings`: limits of the certification.

    Raises `TruthError` if a closed form is asked for and the scene has none; if a certified result
    is asked for and the shot isn't certified to its end; if an integration is asked for and isn't
    possible; or if fewer events are certified than required.
    """
    check_truth(scene, wanted)
    check_closed_form(scene, wanted)
    if wanted == "none":
        return Truth(None, missing="the scene's criteria ask for no reference")
    form = closed_form(scene) if wanted in ("closed-form", None) else None
    # A closed form lacks only these parts.
    needed = form is None or not {"events", "energy", "certificate"}.isdisjoint(parts)
    certificate, no_certificate = (None, "not requested")
    if needed and (wanted != "engine" or "certificate" in parts):
        certificate, no_certificate = certificate_of(scene, settings)
    certified = None  # certified motion of the whole shot
    if certificate is not None and certificate.proved:
        certified = result_of(scene, certificate, CertifiedSettings(), "trajectory")
    partial = (
        no_certificate if certificate is None else f"{certificate.ending}: {certificate.reason}"
    )
    if wanted == "certified" and certified is None:
        raise TruthError(
            f'scene "{scene.name}": its criteria say `truth` = "certified", but the whole shot '
            f'can\'t be certified: {partial}. Write `truth` = "engine"'
        )
    if (
        certificate is not None
        and certified is None
        and (least is None or len(certificate.events) < least)
    ):
        must, found = "all" if least is None else f"{least}", len(certificate.events)
        raise TruthError(
            f'scene "{scene.name}": only {found} of its events are certified, but {must} are '
            f"required: {partial}. If no more can be certified, write `proved` = {found} into its "
            "criteria"
        )
    integration, no_integration = None, ""
    # an integration takes seconds for each slide
    asked = wanted in ("integration", "closed-form")
    if needed and asked and certified is None and may_be_integrated(scene):
        integration, no_integration = integrated(scene)
    if wanted == "integration" and integration is None:
        raise TruthError(
            f'scene "{scene.name}": its criteria say `truth` = "integration", but it can\'t be '
            f'integrated: {no_integration or "it is certified"}. Write `truth` = "engine"'
        )
    # The whole motion, certified or integrated, without Ghostball's engine; None if there is none.
    known = certified
    if integration is not None:
        known = result_of(scene, integration.shot, CertifiedSettings(), "trajectory")
    ours, missing = _our_run(scene) if needed else (None, "not requested")
    if form is not None:
        truth = _from_form(scene, form, ours, known, missing)
    elif certificate is not None and certified is not None and wanted != "engine":
        truth = _from_certificate(certificate, certified)
    elif integration is not None and known is not None:
        truth = replace(_from_certificate(integration.shot, known), kind=INTEGRATION)
    elif ours is not None:
        truth = _from_run(ours)
    else:
        truth = Truth(None, missing=missing)
    meetings, graded, graded_steps, predictable, ends = None, None, None, math.inf, math.inf
    rounding = None
    run = ours if known is None else known
    if truth.kind != CLOSED_FORM and run is not None:
        growth = growth_along(scene, certificate if integration is None else integration.shot, run)
        meetings, ends = meetings_of(growth, run), growth.derivative_ends
        predictable = horizon(growth, TOLERANCE, ROUNDINGS * UNIT_ROUNDOFF)
    # Computing the growth of errors may take longer than a run: it is done once for all engines.
    lateness = None
    if certificate is not None and "certificate" in parts:
        until = math.inf if certified is None else predictable
        if is_differentiated(scene):
            motion = motion_of_certificate(scene, certificate)
            lateness = lateness_of(growth_of_certificate(scene, certificate), scene, motion)
        rounding = growth_along_certificate(scene, certificate).rounding(scene)
        graded = gradable(scene, certificate)
        graded_steps = gradable(scene, certificate, exact=False, until=until)
    return replace(
        truth,
        certified_shot=certified if "certificate" in parts else None,
        certificate=certificate,
        no_certificate=no_certificate,
        meetings=meetings,
        shot_horizon=predictable if math.isfinite(predictable) else ends,
        lateness=lateness,
        rounding=rounding,
        graded=graded,
        graded_steps=graded_steps,
    )


def _from_run(run: Result) -> Truth:
    """Return a run as the reference, with the kind `OUR_ENGINE`."""
    collisions, times = collisions_of(events_of(run))
    return Truth(
        OUR_ENGINE,
        rest_positions=run.rest_positions,
        rest_positions_low=np.zeros_like(run.rest_positions),
        rest_time=run.rest_time,
        collisions=tuple(collisions),
        collision_times=times,
        collision_counts=dict(run.collision_counts),
        motion=run,
    )


def _from_certificate(certificate: Certificate, certified: Result) -> Truth:
    """Return a complete certificate, or an integration, as the reference."""
    high, low = np.zeros((2, len(certified.scene.balls), 3))
    high[:, 2] = certified.scene.radii
    for k, place in enumerate(certificate.positions):
        for axis, enclosure in enumerate(place):
            high[k, axis], low[k, axis] = _halves(enclosure.mid)
    rest_time, rest_time_low = _halves(certificate.t_end.mid)
    return replace(
        _from_run(certified),
        kind=CERTIFIED,
        independent=frozenset({"rest", "time", "events", "energy", "certificate"}),
        rest_positions=high,
        rest_positions_low=low,
        rest_time=rest_time,
        rest_time_low=rest_time_low,
    )


def _from_form(
    scene: Scene, form: ClosedForm, ours: Result | None, known: Result | None, missing: str
) -> Truth:
    """Return a closed form as the reference.

    `known`: the whole motion, certified or integrated, which gives the parts that a closed form
        lacks; None: Ghostball's engine gives them.
    """
    rest = ours if known is None else known
    with mpmath.workdps(DIGITS):
        high, low = _split(
            [[*xy, r] for xy, r in zip(form.rest_positions, scene.radii, strict=True)]
        )
        (time_high,), (time_low,) = _split([form.rest_time])
    collisions = tuple(_from_labels(*collision) for collision in form.event_sequence)
    times = _NO_TIMES
    if rest is not None:
        found, found_times = collisions_of(events_of(rest))
        times = found_times if tuple(found) == collisions else _NO_TIMES
    independent: set[TruthPart] = {"rest", "time", "events", "conditioning", "certificate"}
    return Truth(
        CLOSED_FORM,
        independent=frozenset(independent if known is None else independent | {"energy"}),
        missing=missing,
        rest_positions=high,
        rest_positions_low=low,
        rest_time=float(time_high),
        rest_time_low=float(time_low),
        conditioning=form.conditioning,
        rest_time_conditioning=form.rest_time_conditioning,
        collisions=collisions,
        collision_times=times,
        collision_counts=dict(form.collision_counts),
        motion=rest,
    )


def _our_run(scene: Scene) -> tuple[Result | None, str]:
    """Run Ghostball's engine; return None and the reason if this gives no reference."""
    try:
        result = run_ours(scene)
    except UnsupportedSceneError as error:
        return None, str(error)
    if not result.status.complete:
        return None, f"Ghostball's engine stopped early: {result.status.value}"
    return result, ""


def _split(values: Sequence[Any]) -> tuple[FloatArray, FloatArray]:
    """Split multiprecision values into nearest doubles, and the nearest doubles of the rest."""
    exact = np.array(values, dtype=object)
    high = exact.astype(np.float64)
    low = (exact - high).astype(np.float64)
    return high, low


def _halves(value: Fraction) -> tuple[float, float]:
    """Split a rational number into its nearest double, and the nearest double of the rest."""
    high = float(value)
    return high, float(value - Fraction(high))


def _from_labels(kind: str, a: int, b: int | str) -> Key:
    if kind == EventKind.BALL_CUSHION.label:
        return (int(EventKind.BALL_CUSHION), a, partner_index(EventKind.BALL_CUSHION, str(b)))
    return lower_first(int(EventKind.BALL_BALL), a, int(b))
