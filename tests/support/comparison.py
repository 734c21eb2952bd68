"""The engine against the oracle, event by event, as far as the shot's chaos allows.

How much an error has grown by each instant is measured, not guessed: the oracle plays the shot
again with every number nudged by about 1e-25, at the start and at every event, in 50 digits, where
that is linear. Double precision nudges by half an `EPS`, several times per event; `ROUNDINGS`
allows for those.

Events closer in time than double precision tells apart are compared as a set, where each acts on
balls of its own: so end the slides of a rolling ball and of the resting one that it hit. Where two
such events share a ball, their order decides what comes after, and the comparison ends before them.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass
from typing import Any

from invariants import EPS
from mpmath import mpf, workdps
from oracle import DIGITS, NUDGE, OracleEvent, OracleRun, solve
from oracle_laws import (
    SIDES,
    Body,
    Phase,
    acceleration,
    advanced,
    angular_acceleration,
    dot,
    minus,
    norm,
    scaled,
)

from ghostball.engine import EventKind, Result, Samples, Scene, Status, simulate
from ghostball.engine.result import Events

ROUNDINGS = 64
"""Errors of EPS that a run may add up, amplified by the shot: some ten per event, twenty events.

The largest seen over 500 random shots on the cloth, 7 060 events, was 3.6.
"""

CHAOS = 1e-6
"""Amplification times EPS beyond which nothing is compared."""

RESOLVED = mpf(10) ** -40
"""Differences [SI units] below which the oracle itself, in 50 digits, means nothing."""

LOWEST_HOP = 4e-6
"""Height of a hop, in diameters, up to which two balls, or a ball and a cushion, count as pressed.

A ball that friction drives against another comes back to it in ever shorter bounces. No list of
events tells their end, and the engine has a contact force for it, which takes over at hops of this
height: 2e-7 m.
"""


@dataclass(frozen=True)
class Agreement:
    """How far the comparison went, and the largest error in units of EPS times amplification."""

    events: int
    ball_collisions: int
    ties: int
    reached_the_end: bool
    worst_roundings: float


class Errors:
    """Measures errors in roundings (`EPS` times amplification) and keeps the worst."""

    def __init__(self) -> None:
        self.worst = 0.0

    def check(self, error: Any, growth: Any, what: str) -> None:
        """Assert that `error` is within `ROUNDINGS`; `growth` has the error's unit."""
        if error < RESOLVED:
            return
        roundings = float(error / (EPS * growth))
        self.worst = max(self.worst, roundings)
        assert roundings <= ROUNDINGS, (
            f"{what}: off by {float(error):.3g}, {roundings:.1f} roundings"
        )


def check_against_oracle(
    scene: Scene, *, max_ball_collisions: int = 6, max_events: int = 60
) -> Agreement:
    """Assert that engine and oracle agree: what happens, when, the motion between, and the end."""
    result = simulate(scene, record="events")
    limits = {"max_ball_collisions": max_ball_collisions, "max_events": max_events}
    truth = solve(scene, **limits)
    nudged = [solve(scene, nudge_seed=seed, **limits) for seed in (1, 2)]
    with workdps(DIGITS):
        return compare(result, truth, nudged)


def compare(result: Result, truth: OracleRun, nudged: list[OracleRun]) -> Agreement:
    """Assert that `result` is `truth` within what rounding makes of it; see the module."""
    assert result.events is not None
    growths = _growths(truth, nudged)
    whole = truth.complete and len(growths) == len(truth.events)
    groups = _groups(truth, growths, whole)
    errors, k, before = Errors(), 0, mpf(0)
    for size in groups:
        _check_between(result, truth, nudged, before, truth.events[k].t, errors)
        _check_group(result.events, truth.events[k : k + size], k, growths[k + size - 1], errors)
        k += size
        before = truth.events[k - 1].t
    reached_the_end = truth.complete and k == len(truth.events)
    if reached_the_end:
        assert len(result.events) == k, f"an event too many: {result.events[k]}"
        _check_between(result, truth, nudged, before, truth.t_end, errors)
        _check_end(result, truth, nudged, errors)
    collisions = sum(event.kind is EventKind.BALL_BALL for event in truth.events[:k])
    ties = sum(size > 1 for size in groups)
    return Agreement(k, collisions, ties, reached_the_end, errors.worst)


def _growths(truth: OracleRun, nudged: list[OracleRun]) -> list[Any]:
    """Return the amplification of the times up to each event [s], as far as there is no chaos.

    Events of a tie come in any order, so the n-th event of a kind and its balls is matched with the
    n-th one of the nudged run.
    """
    copies = [_by_key(run.events) for run in nudged]
    seen: Counter[Any] = Counter()
    growths, growth = [], mpf(1)
    for event in truth.events:
        n = seen[event.key]
        if any(len(copy[event.key]) <= n for copy in copies):
            # The limit on events may cut a tie in two; nothing else makes a difference.
            assert not truth.complete, f"a nudge of 1e-25 undid {event.key}"
            break
        seen[event.key] += 1
        shifts = [abs(copy[event.key][n].t - event.t) / NUDGE for copy in copies]
        growth = max(growth, event.t, *shifts)
        if growth * EPS > CHAOS:
            break
        growths.append(growth)
    return growths


def _by_key(events: list[OracleEvent]) -> dict[Any, list[OracleEvent]]:
    found = defaultdict(list)
    for event in events:
        found[event.key].append(event)
    return found


def _groups(truth: OracleRun, growths: list[Any], whole: bool) -> list[int]:
    """Return the sizes of groups of events, one after another, that doubles tell apart in time.

    Ends before a group in which two events share a ball, and before an impact that presses; and
    before the last group where the events aren't the `whole` run, since it may go on.
    """
    sizes: list[int] = []
    events = truth.events[: len(growths)]
    size = 0
    balls: set[int] = set()
    for k, event in enumerate(events):
        if k > 0 and event.t - events[k - 1].t >= 2 * ROUNDINGS * EPS * growths[k]:
            sizes.append(size)
            size, balls = 0, set()
        if balls & set(event.balls) or _presses(event, *truth.moments[k]):
            return sizes
        balls |= set(event.balls)
        size += 1
    return [*sizes, size] if whole and size else sizes


def _presses(event: OracleEvent, start: Any, bodies: list[Body]) -> bool:
    """Whether an event is an impact so slow that what it would make is no hop; see `LOWEST_HOP`.

    At a speed of approach v, under an acceleration a that closes the gap again, a hop rises by at
    most v^2 / 2a. The cloth also stops a ball that is struck at rest. `bodies` are as they were at
    `start`, after the event before.
    """
    if not event.is_collision:
        return False
    a, *others = (advanced(bodies[i], event.t - start) for i in event.balls)
    if others:
        b = others[0]
        line, apart = minus(b.position, a.position), minus(b.velocity, a.velocity)
        normal = scaled(1 / norm(line), line)
        approach = -dot(apart, normal)
        turning = (dot(apart, apart) - approach**2) / norm(line)
        closing = -turning - dot(minus(acceleration(b), acceleration(a)), normal)
        closing += sum(body.rolling for body in (a, b) if body.phase is Phase.RESTING)
        reach = a.radius + b.radius
    else:
        normal = SIDES[event.b]
        approach, closing = dot(a.velocity, normal), dot(acceleration(a), normal)
        reach = 2 * a.radius
    return bool(approach**2 <= 2 * closing * LOWEST_HOP * reach)


def _check_group(
    events: Events, group: list[OracleEvent], k: int, growth: Any, errors: Errors
) -> None:
    """Check the events of a group, from the k-th on: in any order, each at its time."""
    found = [
        ((int(event["kind"]), int(event["a"]), int(event["b"])), mpf(float(event["t"])))
        for event in events[k : k + len(group)]
    ]
    first = f"event {k}, at t = {float(group[0].t)} s"
    assert Counter(key for key, _ in found) == Counter(event.key for event in group), first
    times = dict(found)  # no key twice: events of a group share no ball
    for event in group:
        errors.check(abs(times[event.key] - event.t), growth, f"time of {event}")


def _check_between(
    result: Result, truth: OracleRun, nudged: list[OracleRun], start: Any, end: Any, errors: Errors
) -> None:
    """Check the state of every ball halfway between two instants, if there is a double between."""
    t = float((start + end) / 2)
    if not start < t < end:
        return
    copies = [run.at(mpf(t)) for run in nudged]
    _check_states(result.sample([t]), truth.at(mpf(t)), copies, mpf(t), errors)


def _check_end(result: Result, truth: OracleRun, nudged: list[OracleRun], errors: Errors) -> None:
    assert result.status is (Status.REST if truth.rested else Status.T_MAX)
    growth = max(truth.t_end, *(abs(run.t_end - truth.t_end) / NUDGE for run in nudged))
    errors.check(abs(mpf(result.rest_time) - truth.t_end), growth, "the instant of rest")
    copies = [run.moments[-1][1] for run in nudged]
    _check_states(result.final_state, truth.moments[-1][1], copies, truth.t_end, errors)


def _check_states(
    samples: Samples, bodies: list[Body], copies: list[list[Body]], t: Any, errors: Errors
) -> None:
    """Check one sample of every ball; its numbers' own rounding, and the clock's, are the least."""
    for i, body in enumerate(bodies):
        slowing, turning = norm(acceleration(body)), norm(angular_acceleration(body))
        least = {
            "position": norm(body.position) + body.radius + t * norm(body.velocity),
            "velocity": norm(body.velocity) + t * slowing,
            "spin": norm(body.spin) + t * (turning + body.spinning),
        }
        for (what, size), array in zip(least.items(), samples, strict=True):
            wanted = getattr(body, what)
            # A centre's height is its radius in a sample, and 0 in the oracle.
            found = tuple(map(mpf, (*array[0, i, :2], array[0, i, 2] * (what == "spin"))))
            moved = [norm(minus(getattr(copy[i], what), wanted)) / NUDGE for copy in copies]
            where = f"{what} of ball {i} at t = {float(t)} s"
            errors.check(norm(minus(found, wanted)), max(size, *moved), where)
