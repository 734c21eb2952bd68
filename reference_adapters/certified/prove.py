"""Certify a shot: runs with increasing precision until everything is proved."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from typing import NamedTuple

from flint import arb

from ghostball.model import UnsupportedSceneError
from ghostball.reference_adapters.certified.arithmetic import (
    ZERO,
    OutOfTimeError,
    SustainedContactError,
    UndecidedError,
    computing_until,
    enclosure_of,
    radius_of,
    working_precision,
)
from ghostball.reference_adapters.certified.certificate import (
    Certificate,
    CertifiedEvent,
    Choice,
    Ending,
)
from ghostball.reference_adapters.certified.integrated_slide import Integrator
from ghostball.reference_adapters.certified.motion import Body
from ghostball.reference_adapters.certified.problem import ExactProblem
from ghostball.reference_adapters.certified.recorded import recorded
from ghostball.reference_adapters.certified.run import CertifiedRun
from ghostball.reference_adapters.certified.settings import CertifiedSettings


class _Stop(NamedTuple):
    """Where and why one run ended."""

    ending: Ending
    what: str
    choices: tuple[Choice, ...]
    t: arb
    final: bool  # whether more precision can't help
    events: int  # number of events proved so far


def prove(
    problem: ExactProblem,
    ids: tuple[str, ...],
    settings: CertifiedSettings,
    *,
    motion: bool,
    slide: Integrator | None = None,
) -> Certificate:
    """Prove the events of a problem whose balls have the names `ids`, as far as possible.

    With `motion`, the motion between events is stored, too. With `slide`, an integrator of slides
    in air, the shot is integrated: the result has the form of a proof, but isn't one.

    Raises `UnsupportedSceneError` if it can't be decided how a ball starts.
    """
    started = time.perf_counter()
    deadline = started + settings.time_limit
    run: CertifiedRun | None = None
    stop: _Stop | None = None
    for bits in _precisions(settings):
        # The first precision has no deadline, because there would be nothing to return.
        first = bits == settings.start_precision
        with working_precision(bits), computing_until(math.inf if first else deadline):
            try:
                new = CertifiedRun(problem, bits, slide)
            except UndecidedError as error:
                if error.exact or bits == settings.max_precision or time.perf_counter() > deadline:
                    raise _refused(error.what) from None
                continue
            except OutOfTimeError:
                if stop is None:
                    unknown = (
                        f"in {settings.time_limit:g} s (`time_limit`) it can't verify the initial "
                        "state",
                    )
                    raise UnsupportedSceneError("certified", unknown) from None
                stop = stop._replace(ending="time limit")
                break
        run, before = new, stop
        with working_precision(bits), computing_until(deadline):
            stop = _attempt(run, settings, deadline)
        if not stop.final and time.perf_counter() > deadline:
            stop = stop._replace(ending="time limit", final=True)
        if not stop.final and bits == settings.max_precision:
            stop = _at_max_precision(stop, before)
        if stop.final:
            break
    assert run is not None
    assert stop is not None
    with working_precision(run.bits):
        seconds = time.perf_counter() - started
        return _certificate(run, stop, _reason(stop, ids, settings), seconds, motion)


def _refused(what: str) -> UnsupportedSceneError:
    return UnsupportedSceneError("certified", (f"it can't determine, from the start, {what}",))


def _at_max_precision(stop: _Stop, before: _Stop | None) -> _Stop:
    """Return the ending of a run that more precision might have continued."""
    if stop.ending not in ("ambiguous", "proved"):
        return stop._replace(final=True)
    # If the last increase of precision didn't help, the numbers are presumably equal.
    further = before is None or stop._replace(t=before.t) != before
    tie = stop.ending == "ambiguous" and not further
    return stop._replace(ending="ambiguous" if tie else "precision cap", final=True)


def _precisions(settings: CertifiedSettings) -> Iterator[int]:
    bits = settings.start_precision
    while bits < settings.max_precision:
        yield bits
        bits *= 2
    yield settings.max_precision


def _attempt(run: CertifiedRun, settings: CertifiedSettings, deadline: float) -> _Stop:
    """Run with one precision; return where and why the run ended."""
    try:
        ending = run.go(settings.max_events, deadline)
        end = run.end_instant() if run.ended else run.now
        stop = _Stop(ending, f"positions to {settings.width:g} m (`width`)", (), end, True, 0)
    except SustainedContactError as error:
        stop = _Stop("sustained contact", error.what, error.choices, error.t, True, 0)
    except OutOfTimeError:
        stop = _Stop("time limit", "", (), run.now, True, 0)
    except UndecidedError as error:
        stop = _Stop("ambiguous", error.what, error.choices, error.t, error.exact, 0)
    end = stop.t if run.ended else run.now
    final = stop.final and _widest(run, end) <= settings.width
    return stop._replace(final=final, events=len(run.events))


def _widest(run: CertifiedRun, end: arb) -> float:
    """Return the width of the widest number in the certificate, in m, s and m/s."""
    numbers = [end, *(t for _, t, _ in run.events)]
    for body in run.bodies:
        place, velocity, spin = _state_at(body, end, run.airborne)
        numbers += [*place, *velocity, *(body.constants.radius * w for w in spin)]
    return 2.0 * max(map(radius_of, numbers))


def _reason(stop: _Stop, ids: tuple[str, ...], settings: CertifiedSettings) -> str:
    named = "; ".join(choice.describe(ids) for choice in stop.choices)
    colon = ": " if named else ""
    at = f"{colon}{named}, at t = {float(stop.t):.17g} s"
    if stop.ending == "ambiguous":
        return f"can't determine {stop.what}{at}"
    if stop.ending == "precision cap":
        cap = f"{settings.max_precision} bits (`max_precision`) are not enough to determine"
        return f"{cap} {stop.what}{at}. Raise it"
    if stop.ending == "sustained contact":
        return f"{stop.what}, from here on{at}"
    if stop.ending == "event limit":
        return f"{settings.max_events} events (`max_events`){at}"
    if stop.ending == "time limit":
        return f"{settings.time_limit:g} s of computing (`time_limit`){at}"
    return ""


def _certificate(
    run: CertifiedRun, stop: _Stop, reason: str, seconds: float, motion: bool
) -> Certificate:
    positions, velocities, spins = [], [], []
    end = stop.t if run.ended else run.now
    for body in run.bodies:
        place, velocity, spin = _state_at(body, end, run.airborne)
        positions.append(tuple(map(enclosure_of, place)))
        velocities.append(tuple(map(enclosure_of, velocity)))
        spins.append(tuple(map(enclosure_of, spin)))
    moved = recorded(run, end)._asdict() if motion else {}
    return Certificate(
        ending=stop.ending,
        reason=reason,
        choices=stop.choices,
        precision=run.bits,
        events=tuple(
            CertifiedEvent(choice.kind, choice.a, choice.b, enclosure_of(t), tie)
            for choice, t, tie in run.events
        ),
        t_end=enclosure_of(end),
        rested=run.rested,
        positions=tuple(positions),
        velocities=tuple(velocities),
        spins=tuple(spins),
        seconds=seconds,
        **moved,
    )


def _state_at(
    body: Body, t: arb, in_space: bool
) -> tuple[tuple[arb, ...], tuple[arb, ...], tuple[arb, ...]]:
    s = ZERO if body.t is t else t - body.t
    place: tuple[arb, ...] = (body.x, body.y) if body.resting else body.position_after(s)
    velocity: tuple[arb, ...] = (body.vx, body.vy) if body.resting else body.velocity_after(s)
    slip, radius = body.slip_after(s), body.constants.radius
    # From u = (vx - R wy, vy + R wx).
    wx, wy = (slip[1] - velocity[1]) / radius, (velocity[0] - slip[0]) / radius
    if in_space:
        height, up, _ = body.vertical_after(s)
        place, velocity = (*place, height), (*velocity, up)
    return place, velocity, (wx, wy, body.spin_after(s))
