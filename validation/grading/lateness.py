"""First-order effects on a shot if an engine detects its events late, by up to a time step.

    >>> lateness = lateness_of(growth_of_certificate(scene, certificate), scene, motion)
    >>> lateness.places.T @ delays      # rest position errors, (n,) [m]

The derivatives are those of the certified motion (`certified_growth`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ghostball.model import EventKind, ExactTrajectory, Scene
from ghostball.model.arrays import FloatArray
from ghostball.model.trajectory.segment import WZ
from ghostball.validation.grading.certified_flow import PARTS, PLACE, SPIN, CertifiedBall, rows_of
from ghostball.validation.grading.certified_growth import CertifiedGrowth, energy_slopes
from ghostball.validation.grading.other_paths import MOST_EVENTS, Margins, margins_along
from ghostball.validation.grading.phase_ends import PHASE_ENDS


@dataclass(frozen=True, eq=False)
class Lateness:
    """Effects of a late detection of each event of a shot, per second of delay.

    `times` (events,) float64 [s].
    `balls`: the balls of each event.
    `approach` (events,) float64 [m/s]: approach speed of each collision; 0 for other events.
    `places` (events, n) float64 [m/s]: rest position error of each ball; NaN if no derivative
        exists.
    `comes` (events, events) float64 [1]: largest time shift of each event by a delay of each
        earlier event.
    `rests` (events,) float64 [1]: time shift of the rest of the last ball.
    `energies` (events,) float64 [W]: largest error of the energy of all balls.
    `strays` (events,) float64 [m/s]: largest distance of a ball from its path at any time.
    `margins`: delays that may change the collisions; None if they are unknown.

    `rests`, `energies` and `strays` are NaN if no derivative exists, and in shots with more than
    `MOST_EVENTS` events; `comes` is NaN from the first event without a derivative. All four allow
    for a solver that collides balls with the speeds that they had before its step.
    """

    kinds: tuple[EventKind, ...]
    times: FloatArray
    balls: tuple[tuple[int, ...], ...]
    approach: FloatArray
    places: FloatArray
    comes: FloatArray
    rests: FloatArray
    energies: FloatArray
    strays: FloatArray
    margins: Margins | None


def lateness_of(growth: CertifiedGrowth, scene: Scene, motion: ExactTrajectory) -> Lateness:
    """Return the effects on the shot of this scene if each of its events is detected late.

    `motion`: the certified motion.

    The effects on the end are computed backwards along the shot: the derivative of the end by the
    state after each event, times the change of this state per second of delay. The effects on
    events in between are computed forwards: see `_followed`.
    """
    n, size = len(growth.balls), PARTS * len(growth.balls)
    end = np.zeros((2 * n, size))
    for i, ball in enumerate(growth.balls):
        _, flow = ball.displacement(np.array([growth.t_end]))
        end[2 * i : 2 * i + 2, PARTS * i : PARTS * (i + 1)] = flow[0]
    moved = np.full((len(growth.events), 2 * n), np.nan)
    with np.errstate(over="ignore", invalid="ignore"):
        for e in reversed(range(len(growth.events))):
            event, rows = growth.events[e], rows_of(growth.events[e].balls)
            if event.matrix is None or event.late is None:
                break  # earlier events have no derivative of the end
            moved[e] = end[:, rows] @ event.late
            end[:, rows] = end[:, rows] @ event.matrix
    places = np.hypot(moved[:, ::2], moved[:, 1::2])
    return Lateness(
        tuple(event.kind for event in growth.events),
        np.array([event.t for event in growth.events]),
        tuple(event.balls for event in growth.events),
        np.array([event.approach for event in growth.events]),
        places,
        *_followed(growth, scene),
        margins_along(scene, motion, growth.balls, growth.events),
    )


def _followed(
    growth: CertifiedGrowth, scene: Scene
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return `comes`, `rests`, `energies` and `strays` of `Lateness`.

    The change of each ball per second of delay at each earlier event is propagated along the shot,
    and so is the change by velocities, or surface velocities, that are a second old. At each event
    they give the time shift of the event, and the change of the energy of its balls.

    Energies of balls are added without their signs. Between events they change as described in
    `CertifiedGrowth.rounding`, so the largest value at a ball's events is a bound.

    The end of a phase is shifted by at most `CertifiedBall.end_shifted`, even if a change is as
    large as the slip; a roll is also shifted by the slide before it.
    """
    many = min(len(growth.events), MOST_EVENTS)
    changes = np.zeros((3, PARTS * len(growth.balls), many))
    comes, rests, strays = np.zeros((many, many)), np.zeros(many), np.zeros(many)
    energies = np.zeros((len(growth.balls), many))
    starts, slides = [ball.starts[0] for ball in growth.balls], np.zeros_like(energies)
    slopes = [
        energy_slopes(ball, float(mass))
        for ball, mass in zip(growth.balls, scene.masses, strict=True)
    ]
    with np.errstate(over="ignore", invalid="ignore"):
        for e, event in enumerate(growth.events[:many]):
            rows, matrix, later = rows_of(event.balls), event.matrix, event.later
            if matrix is None or later is None or event.stale is None:
                comes[e:] = rests[:] = energies[:] = strays[:] = np.nan
                break
            moved = np.sum(np.abs(later @ changes[:, rows]), axis=0)
            if event.t == growth.t_end:
                rests = np.maximum(rests, moved)
            slid = slides[event.balls[0]].copy()
            slides[list(event.balls)] = 0.0
            if event.kind in PHASE_ENDS:
                (i,) = event.balls
                own = changes[:, PARTS * i : PARTS * (i + 1)]
                shifted = np.sum(growth.balls[i].end_shifted(starts[i], own), axis=0)
                moved = np.maximum(moved, shifted) + slid
                if event.kind is EventKind.SLIDE_TO_ROLL:
                    slides[i] = moved
            comes[e] = moved
            for i in event.balls:
                strays = np.maximum(strays, _strayed(growth.balls[i], i, changes, event.t))
            changes[:, rows] = matrix @ changes[:, rows]
            changes[0, rows, e] += event.late
            changes[1:, rows, e] += event.stale
            for i, k in zip(event.balls, event.segments, strict=True):
                starts[i] = k
                own = changes[:, PARTS * i : PARTS * (i + 1)]
                beside = np.sum(np.linalg.norm(own[:, PLACE], axis=1), axis=0)
                strays = np.maximum(strays, beside)
                more = np.sum(np.abs(slopes[i][k] @ own), axis=0)
                energies[i] = np.maximum(energies[i], more)
    if not many or growth.events[-1].t < growth.t_end:  # a ball that spins in place is the last
        for i, ball in enumerate(growth.balls):
            if ball.spins_by > 0.0 and ball.segments[-1, WZ] != 0.0:
                spins = np.sum(np.abs(changes[:, PARTS * i + SPIN]), axis=0)
                rests = np.maximum(rests, spins / ball.spins_by)
    if many < len(growth.events):
        unknown = np.full(len(growth.events), np.nan)
        return comes, unknown, unknown, unknown
    for i in range(len(growth.balls)):
        strays = np.maximum(strays, _strayed(growth.balls[i], i, changes, growth.t_end))
    return comes, rests, np.sum(energies, axis=0), strays


def _strayed(ball: CertifiedBall, i: int, changes: FloatArray, t: float) -> FloatArray:
    """Return the displacement of ball i just before t [s] by changes of its state, (events,).

    Between two events of the ball, the displacement is a convex function of the time.
    """
    _, (flow,) = ball.displacement(np.array([max(np.nextafter(t, 0.0), 0.0)]))
    with np.errstate(over="ignore", invalid="ignore"):
        moved = flow @ changes[:, PARTS * i : PARTS * (i + 1)]
        strayed: FloatArray = np.sum(np.linalg.norm(moved, axis=1), axis=0)
    return strayed
