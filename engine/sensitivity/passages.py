"""The effect of each event of a recorded shot on small changes of its balls, as a matrix.

Between events, a change follows the derivative of the closed form (`sensitivity.motion`). With the
change dz, an event h = 0 comes later by dtau = -(grad h . dz) / (grad h . f), and the change after
it is dz+ = DG (dz- + f- dtau) - f+ dtau (saltation). f- and f+ are the rates of change before and
after, DG is the derivative of the event's map. For impact laws DG is a central difference
(`sensitivity.laws`).

Each event has a matrix. It maps changes at the starts of the segments before the event to changes
at the starts of the segments after the event.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ghostball.engine.core import state as st
from ghostball.engine.motion.obstacles import facing, row_at, turning
from ghostball.engine.sensitivity.laws import (
    SEEN,
    VN,
    VT,
    WN,
    WT,
    WZ as ALONG_Z,
    differentiated,
    played,
)
from ghostball.engine.sensitivity.motion import (
    PARTS,
    VX,
    VY,
    WX,
    WY,
    WZ,
    FloatArray,
    Rows,
    SegmentedMotion,
    X,
    Y,
)
from ghostball.model.events import EventKind, Events

_CHUNK = 1024
"""Number of events whose matrices and simulated impacts are in memory at once: about 6 kB each."""


class Passages(NamedTuple):
    """The effect of m events of `count` balls each on changes; d is `count` times PARTS.

    `number` (m,): indices of the events.
    `before`, `after` (m, count): the segments that end and start with them.
    `matrix` (m, d, d): maps changes at the starts of `before` to those at the starts of `after`.
    `later` (m, d) [s]: delay of the event per change at the starts of `before`.
    `size` (m, PARTS): the largest size of velocity and angular velocity just before them.
    """

    number: Rows
    before: Rows
    after: Rows
    matrix: FloatArray
    later: FloatArray
    size: FloatArray


@dataclass(frozen=True, eq=False)
class Links:
    """The segments that each event ends and starts; events of one ball use the first column only.

    `before`, `after` (events, 2): -1 if changes after the event are unknown.
    `lost` (k,): whether changes at the start of a segment are unknown.
    """

    before: Rows
    after: Rows
    lost: NDArray[np.bool_]


def links_of(motion: SegmentedMotion, events: Events) -> Links:
    """Return the segments that each event ends and starts.

    No first-order change exists if a ball has two collisions at one time, because any change
    decides their order. No first-order change exists either if a segment starts without an event:
    the segment then comes from a resting contact, whose forces aren't recorded.
    """
    at, last = motion.first[:-1].tolist(), (motion.first[1:] - 1).tolist()
    epochs = motion.segments[:, st.EPOCH].tolist()
    before, after = np.full((2, len(events), 2), -1)
    lost = np.zeros(len(epochs), dtype=np.bool_)
    collisions = collisions_at_once(events)

    def reach(ball: int, t: float) -> bool:
        """Move a ball to its last segment before t; return whether a segment starts at t."""
        while at[ball] < last[ball] and epochs[at[ball] + 1] < t:
            at[ball] += 1
            lost[at[ball]] = True
        return bool(at[ball] < last[ball] and epochs[at[ball] + 1] == t)

    rows = zip(events["t"].tolist(), *(events[name].tolist() for name in "ab"), strict=True)
    of_pairs = (events["kind"] == EventKind.BALL_BALL).tolist()
    for e, (t, *balls) in enumerate(rows):
        if not of_pairs[e]:
            balls.pop()
        reached = [reach(ball, t) for ball in balls]
        alone = all(reached) and all(collisions.get((t, ball), 0) < 2 for ball in balls)
        for place, ball in enumerate(balls):
            if alone:
                before[e, place], after[e, place] = at[ball], at[ball] + 1
            at[ball] += reached[place]
            if not alone:
                lost[at[ball]] = True
    for ball, end in enumerate(last):
        lost[at[ball] + 1 : end + 1] = True
    return Links(before, after, lost)


def collisions_at_once(events: Events) -> dict[tuple[float, int], int]:
    """Return the number of collisions of each ball at each time at which it has any."""
    counts: dict[tuple[float, int], int] = {}
    for t, kind, a, b in events.tolist():
        if kind in (EventKind.BALL_BALL, EventKind.BALL_CUSHION):
            counts[t, a] = counts.get((t, a), 0) + 1
        if kind == EventKind.BALL_BALL:
            counts[t, b] = counts.get((t, b), 0) + 1
    return counts


def passages(motion: SegmentedMotion, events: Events, links: Links) -> Iterator[list[Passages]]:
    """Yield the effects of events, in groups: events of one ball, and of two balls."""
    for start in range(0, len(events), _CHUNK):
        number = np.arange(start, min(start + _CHUNK, len(events)))
        number = number[links.before[number, 0] >= 0]
        kind = events["kind"][number]
        impacts, bounces = kind == EventKind.BALL_BALL, kind == EventKind.BALL_CUSHION
        holes = kind == EventKind.POCKETED
        found = []
        for chosen, through in (
            (impacts, _through_impacts),
            (bounces, _through_bounces),
            (holes, _into_pockets),
            (~(impacts | bounces | holes), _through_own_ends),
        ):
            if np.any(chosen):
                passed = through(_Crossing.of(motion, events, links, number[chosen]))
                passed.matrix.reshape(*passed.after.shape, -1)[links.lost[passed.after]] = np.nan
                found.append(passed)
        yield found


@dataclass(frozen=True, eq=False)
class _Crossing:
    """Events of one kind, of `count` balls each, and the motion of their balls before them.

    `here`, `rate` (m, count, PARTS): the states just before, and their rates of change f-.
    `arrived` (m, d, d): propagation of changes from the starts of the segments to the events.
    """

    motion: SegmentedMotion
    number: Rows
    times: FloatArray
    partner: NDArray[np.int64]
    before: Rows
    after: Rows
    here: FloatArray
    rate: FloatArray
    arrived: FloatArray

    @classmethod
    def of(cls, motion: SegmentedMotion, events: Events, links: Links, number: Rows) -> _Crossing:
        """Return the events with some indices."""
        count = 2 if events["kind"][number[0]] == EventKind.BALL_BALL else 1
        before, after = links.before[number, :count], links.after[number, :count]
        times = np.repeat(events["t"][number], count)
        rows = before.ravel()
        here, rate = motion.arrivals(rows, times)
        flows = motion.flows(rows, times - motion.segments[rows, st.EPOCH])
        flows = flows.reshape(len(number), count, PARTS, PARTS)
        arrived = np.zeros((len(number), count, PARTS, count, PARTS))
        for k in range(count):
            arrived[:, k, :, k] = flows[:, k]
        size = count * PARTS
        return cls(
            motion,
            number,
            events["t"][number],
            events["b"][number],
            before,
            after,
            here.reshape(len(number), count, PARTS),
            rate.reshape(len(number), count, PARTS),
            arrived.reshape(len(number), size, size),
        )

    def of_balls(self, column: int) -> FloatArray:
        """Return a number of each ball, (m, count)."""
        found: FloatArray = self.motion.of_balls(column)[self.before]
        return found

    def met(self, later: FloatArray) -> FloatArray:
        """Return changes at the place and time of each changed event, (m, count, PARTS, d).

        This adds f- dtau.
        """
        shifted = self.arrived + _outer(self.rate.reshape(self.arrived.shape[:2]), later)
        return shifted.reshape(*self.rate.shape, -1)

    def left(self, changed: FloatArray, later: FloatArray) -> Passages:
        """Return the effect of the events, from changes just after the changed events.

        The changes are moved back to the time of the unchanged events, which subtracts f+ dtau. A
        ball that has no slip after an impact rolls immediately. A changed ball slides first, for a
        time of the order of the change, in which the cloth takes 2/7 of the slip. Likewise, a ball
        at rest after an impact stops again immediately if the cloth slows it.

        `changed` (m, count, PARTS, d).
        `later` (m, d).
        """
        phase = self.motion.segments[self.after, st.PHASE]
        radius = self.of_balls(st.RADIUS)
        if self.motion.laws.slides:
            ended = np.where(phase != st.SLIDING, 1.0 / 3.5, 0.0)[:, :, np.newaxis]
            lever = radius[:, :, np.newaxis]
            slip_x = changed[:, :, VX] - lever * changed[:, :, WY]
            slip_y = changed[:, :, VY] + lever * changed[:, :, WX]
            changed[:, :, VX] -= ended * slip_x
            changed[:, :, VY] -= ended * slip_y
        stops = np.equal(phase, st.RESTING) & (self.of_balls(st.ROLL_SLOWING) > 0.0)
        changed[stops, VX : VY + 1] = 0.0
        departing = self.motion.departures(self.after.ravel()).reshape(self.rate.shape)
        matrix = changed.reshape(self.arrived.shape)
        matrix = matrix - _outer(departing.reshape(matrix.shape[:2]), later)
        size = np.max(np.abs(self.here), axis=1)
        return Passages(self.number, self.before, self.after, matrix, later, size)


def _outer(rates: FloatArray, later: FloatArray) -> FloatArray:
    return rates[:, :, np.newaxis] * later[:, np.newaxis, :]


def _through_impacts(at: _Crossing) -> Passages:
    """Return the effect of impacts of two balls each on changes.

    dtau is n . dr over the approach speed. The changed balls touch along a normal turned by
    t . dr / |r|; the law acts in the frame of this normal.
    """
    motion, m = at.motion, len(at.number)
    places = motion.segments[at.after, st.X : st.Y + 1]
    apart = places[:, 1] - places[:, 0]
    distance = np.sqrt(apart[:, 0] * apart[:, 0] + apart[:, 1] * apart[:, 1])
    frame = _frames(apart / distance[:, np.newaxis])
    toward = at.here[:, 0, VX : VY + 1] - at.here[:, 1, VX : VY + 1]
    along_n, along_t = (frame @ toward[:, :, np.newaxis])[:, :, 0].T
    arrived = at.arrived.reshape(m, 2, PARTS, -1)
    moved = frame @ (arrived[:, 1, X : Y + 1] - arrived[:, 0, X : Y + 1])
    later = moved[:, 0] / along_n[:, np.newaxis]
    theta = (moved[:, 1] - along_t[:, np.newaxis] * later) / distance[:, np.newaxis]
    return _through_law(at, places, [()] * m, frame, later, theta)


def _through_bounces(at: _Crossing) -> Passages:
    """Return the effect of bounces off obstacles, which are round like a ball at rest, or flat."""
    rows, frame, later, theta = _obstacles_met(at, takes_out=False)
    places = at.motion.segments[at.after, st.X : st.Y + 1]
    return _through_law(at, places, [(row,) for row in rows], frame, later, theta)


def _through_law(
    at: _Crossing,
    places: FloatArray,
    met: Sequence[tuple[int, ...]],
    frame: FloatArray,
    later: FloatArray,
    theta: FloatArray,
) -> Passages:
    """Return the effect of impacts, whose laws act in the frames of the contacts.

    `places` (m, count, 2): positions of the balls [m].
    `met`: the rows of the obstacles that the balls hit, for each impact.
    `theta` (m, d): turning of the frames with the changes: n by theta t, and t by -theta n.
    """
    m, count = at.before.shape
    changed = at.met(later)
    local = _seen(frame, at.here)
    outcomes = played(at.motion.layout, at.motion.ball[at.before], places, frame, met)
    after, slopes = differentiated(outcomes, local, at.of_balls(st.RADIUS))
    seen = _seen_columns(frame, changed) + _turned_with(local, theta)
    given = (slopes @ seen.reshape(m, count * SEEN, -1)).reshape(seen.shape)
    given -= _turned_with(after.reshape(local.shape), theta)
    back = frame.transpose(0, 2, 1)[:, np.newaxis]
    changed[:, :, VX : VY + 1] = back @ given[:, :, VN : VT + 1]
    changed[:, :, WX : WY + 1] = back @ given[:, :, WN : WT + 1]
    changed[:, :, WZ] = given[:, :, ALONG_Z]
    return at.left(changed, later)


def _into_pockets(at: _Crossing) -> Passages:
    """Return the effect of a hole: the ball stops where its centre enters the hole."""
    _, _, later, _ = _obstacles_met(at, takes_out=True)
    changed = at.met(later)
    changed[:, :, VX:] = 0.0
    return at.left(changed, later)


def _through_own_ends(at: _Crossing) -> Passages:
    """Return the effect of the end of a slide or a roll.

    A slide lasts |u| / (3.5 mu_s g), and a roll |v| / (mu_r g), so dtau follows from the changes at
    the start of the segment.
    """
    rows = at.before[:, 0]
    slides = at.motion.slides[rows]
    slip, radius = at.motion.slip[rows], at.of_balls(st.RADIUS)[:, 0]
    slows = np.where(
        slides, 3.5 * at.of_balls(st.SLIDE_SLOWING)[:, 0], at.of_balls(st.ROLL_SLOWING)[:, 0]
    )
    by = slip / (slows * np.sqrt(slip[:, 0] * slip[:, 0] + slip[:, 1] * slip[:, 1]))[:, np.newaxis]
    lever = np.where(slides, radius, 0.0)
    later = np.zeros((len(rows), PARTS))
    later[:, VX : VY + 1] = by
    later[:, WX], later[:, WY] = lever * by[:, 1], -lever * by[:, 0]
    return at.left(at.met(later), later)


def _obstacles_met(
    at: _Crossing, *, takes_out: bool
) -> tuple[list[int], FloatArray, FloatArray, FloatArray]:
    """Return the rows of the obstacles, the frames of the contacts, and their changes.

    The last two results are the delay of the contacts, (m, PARTS) [s], and the turning of the
    normals, (m, PARTS), per change.
    """
    laws, rows = at.motion.laws, []
    normals, turns = np.empty((len(at.number), 2)), np.empty((len(at.number), 1))
    places = at.motion.segments[at.after[:, 0], st.X : st.Y + 1].tolist()
    for k, (index, (x, y)) in enumerate(zip(at.partner.tolist(), places, strict=True)):
        row = row_at(laws, index, takes_out, x, y)
        inward = facing(laws, row, x, y)
        normals[k] = -inward[0], -inward[1]
        turns[k] = turning(laws, row, x, y)
        rows.append(row)
    frame = _frames(normals)
    approach, along = (frame @ at.here[:, 0, VX : VY + 1, np.newaxis])[:, :, 0].T
    moved = frame @ at.arrived[:, X : Y + 1]
    later = -moved[:, 0] / approach[:, np.newaxis]
    theta = -turns * (moved[:, 1] + along[:, np.newaxis] * later)
    return rows, frame, later, theta


def _frames(normals: FloatArray) -> FloatArray:
    """Return the matrices that map a vector to components along n and t = z x n, (m, 2, 2)."""
    nx, ny = normals.T
    return np.array([[nx, ny], [-ny, nx]]).transpose(2, 0, 1)


def _seen(frame: FloatArray, here: FloatArray) -> FloatArray:
    """Return velocities and angular velocities along n and t of states, (m, count, 5)."""
    return _seen_columns(frame, here[..., np.newaxis])[..., 0]


def _seen_columns(frame: FloatArray, columns: FloatArray) -> FloatArray:
    turn = frame[:, np.newaxis]
    velocity, turning = turn @ columns[:, :, VX : VY + 1], turn @ columns[:, :, WX : WY + 1]
    return np.concatenate((velocity, turning, columns[:, :, WZ:]), axis=2)


def _turned_with(local: FloatArray, theta: FloatArray) -> FloatArray:
    """Return changes of states `local` (m, count, SEEN) by turning frames, (m, count, SEEN, d)."""
    vn, vt, wn, wt, _ = np.moveaxis(local, 2, 0)
    gained = np.stack((vt, -vn, wt, -wn, 0.0 * vn), axis=2)
    return gained[..., np.newaxis] * theta[:, np.newaxis, np.newaxis]
