"""A certificate of a shot: runs in wider and wider precision until everything is proved."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
from flint import arb
from numpy.typing import NDArray

from engine.trajectory import Phase
from reference_adapters.certified.arithmetic import (
    ZERO,
    SustainedContactError,
    UndecidedError,
    enclosure_of,
    working_precision,
)
from reference_adapters.certified.certificate import (
    Certificate,
    CertifiedEvent,
    Choice,
    Ending,
)
from reference_adapters.certified.motion import Body
from reference_adapters.certified.problem import Problem
from reference_adapters.certified.run import Run
from reference_adapters.certified.settings import CertifiedSettings


def prove(
    problem: Problem, ids: tuple[str, ...], settings: CertifiedSettings, *, motion: bool
) -> Certificate:
    """Prove what happens in a problem whose balls have these names.

    With `motion` the motion between events is kept, too.
    """
    started = time.perf_counter()
    deadline = started + settings.time_limit
    stop: tuple[int, str, tuple[Choice, ...]] | None = None
    for bits in _precisions(settings.start_precision, settings.max_precision):
        last = 2 * bits > settings.max_precision
        with working_precision(bits):
            run = Run(problem, bits)
            ending, reason, choices, decided = "proved", "", (), True
            try:
                ending = run.go(settings.max_events, deadline)
                if ending == "proved":
                    end = run.end_instant()
            except SustainedContactError as error:
                ending = "sustained contact"
                choices = error.choices
                reason = _sentence(f"{error.what}, sustained from here on", choices, ids, run.now)
            except UndecidedError as error:
                # Where more bits don't get any further, they are equal for all that can be known.
                here = (len(run.events), error.what, error.choices)
                decided = error.exact
                ending = "ambiguous" if error.exact or here == stop else "precision cap"
                stop = here
                choices = error.choices
                reason = _sentence(f"can't tell {error.what}", choices, ids, error.t)
                if ending == "precision cap":
                    reason += f" in {bits} bits (`max_precision`)"
            certificate = None
            if ending == "proved":
                certificate = _certificate(run, ending, "", (), end, started, motion)
                decided = certificate.widest <= settings.width
                if not decided:
                    certificate = None
                    if last:
                        ending = "precision cap"
                        reason = f"positions are wider than {settings.width:g} m in {bits} bits (`max_precision`)"
            if decided or last or time.perf_counter() > deadline:
                if certificate is None:
                    if ending == "event limit":
                        reason = f"{settings.max_events} events (`max_events`) by t = {float(run.now):.9g} s"
                    elif ending == "time limit":
                        reason = (
                            f"{settings.time_limit:g} s of computing (`time_limit`) by t = "
                            f"{float(run.now):.9g} s"
                        )
                    end = run.end_instant() if run.ended else run.now
                    certificate = _certificate(run, ending, reason, choices, end, started, motion)
                return certificate
    raise AssertionError("there is a last precision")


def _precisions(start: int, most: int) -> Iterator[int]:
    bits = min(start, most)
    while bits <= most:
        yield bits
        bits *= 2


def _sentence(what: str, choices: tuple[Choice, ...], ids: tuple[str, ...], t: arb) -> str:
    named = "; ".join(choice.describe(ids) for choice in choices)
    return f"{what}{': ' if named else ''}{named}, at t = {float(t):.17g} s"


def _certificate(
    run: Run,
    ending: str,
    reason: str,
    choices: tuple[Choice, ...],
    end: arb,
    started: float,
    motion: bool,
) -> Certificate:
    positions, velocities, spins = [], [], []
    for body in run.bodies:
        place, velocity, spin = _state_at(body, end)
        positions.append(tuple(map(enclosure_of, place)))
        velocities.append(tuple(map(enclosure_of, velocity)))
        spins.append(tuple(map(enclosure_of, spin)))
    named: Ending = ending  # type: ignore[assignment]
    return Certificate(
        ending=named,
        reason=reason,
        choices=choices,
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
        seconds=time.perf_counter() - started,
        knots=_knots(run) if motion else None,
    )


def _state_at(body: Body, t: arb) -> tuple[tuple[arb, ...], tuple[arb, ...], tuple[arb, ...]]:
    s = ZERO if body.t is t else t - body.t
    place = (body.x, body.y) if body.resting else body.position_after(s)
    velocity = (body.vx, body.vy) if body.resting else body.velocity_after(s)
    wx, wy = _turning(body, velocity, body.slip_after(s))
    return place, velocity, (wx, wy, body.spin_after(s))


def _turning(body: Body, velocity: tuple[arb, arb], slip: tuple[arb, arb]) -> tuple[arb, arb]:
    """Return the angular velocity about the horizontal, from u = (vx - R wy, vy + R wx)."""
    radius = body.constants.radius
    return (slip[1] - velocity[1]) / radius, (velocity[0] - slip[0]) / radius


def _knots(run: Run) -> tuple[NDArray[np.float64], ...]:
    """Return the motion of each ball in doubles, as an `ExactTrajectory` has it."""
    rows: list[list[tuple[float, ...]]] = [[] for _ in run.bodies]
    for k, body in run.knots:
        wx, wy = _turning(body, (body.vx, body.vy), (body.ux, body.uy))
        radius, slides = body.constants.radius, body.phase is Phase.SLIDING
        bx = 5 * body.ay / (2 * radius) if slides else ZERO
        by = -5 * body.ax / (2 * radius) if slides else ZERO
        numbers = (body.t, body.x, body.y, body.vx, body.vy, body.ax, body.ay)
        numbers += (wx, wy, body.wz, bx, by, ZERO)
        rows[k].append((*map(float, numbers), float(body.phase)))
    return tuple(np.array(row, dtype=np.float64) for row in rows)
