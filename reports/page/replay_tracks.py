"""Paths of balls for the replay of a scene: sampled paths as a few parabolas, written as bytes.

Between events, the acceleration of a ball is constant or nearly so, and a browser draws a parabola
without loss. A path is therefore stored as *pieces*. Each piece has its end position and its bulge:
the distance of the parabola from the chord at mid-time. For the rotation of the ball, each piece
also has the spin at its start and its end, minus the spin of a ball that rolls along the piece. The
difference is mostly 0.

All numbers are integers: positions in micrometres, times in ticks. `packed` writes a small integer
as one byte; the bytes of all balls of a scene are then compressed together.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ghostball.model import Events
from ghostball.model.arrays import FloatArray, IntArray
from ghostball.validation.results.records import Motion

TOLERANCE = 1e-5
"""Largest distance of a path from the stored samples [m]: a tenth of what a reader can see."""

QUANTUM = 1e-6
"""Unit of positions [m]."""

TICK = 1e-7
"""Largest unit of times [s]: a ball at 10 m/s moves by a micrometre in this time."""

FARTHEST = 1e5
"""A ball with a coordinate beyond this value [m] counts as lost, as in an unstable simulation."""

SPIN_QUANTUM = 0.02
"""Unit of spins [rad/s]: rounding to it changes the rotation in 1 s by at most 0.02 rad."""

TURN_TOLERANCE = 0.1
"""Largest error of the rotation within a piece [rad]."""

UNKNOWN_PHASE = 5
"""Phase of a piece from recorded frames, which have no phases."""


@dataclass(frozen=True, eq=False)
class ReplayTrack:
    """The path of one ball in pieces.

    `samples` (m + 1,) int64: indices of the samples at which the pieces start and end; empty if no
        position is known.
    `ends` (m + 1, 3) int64 [`QUANTUM`]: positions at these samples.
    `bulges` (m, 3) int64 [`QUANTUM`]: distance from the chord at the mid-time of each piece.
    `spins` (m, 6) int64 [`SPIN_QUANTUM`]: spin at the start and at the end of each piece, minus the
        spin of a ball that rolls along the piece.
    `phases` (m,) int64: `model.trajectory.Phase`, or `UNKNOWN_PHASE`.
    `lost` [s]: time of the first position that isn't finite or is too far away, or None.
    """

    samples: IntArray
    ends: IntArray
    bulges: IntArray
    spins: IntArray
    phases: IntArray
    lost: float | None


def tick_of(motion: Motion) -> float:
    """Return the unit of times of a motion [s]: no coordinate changes by more than `QUANTUM`."""
    speeds = np.abs(motion.velocities)
    speed = np.max(speeds, initial=0.0, where=np.isfinite(speeds) & (speeds < 1e9))
    return float(min(TICK, QUANTUM / speed)) if speed > 0.0 else TICK


def track_of(motion: Motion, ball: int, tick: float, radius: float) -> ReplayTrack:
    """Return the path of one ball as parabolas within `TOLERANCE` of its samples.

    `tick` [s]: unit of times.
    `radius` [m]: radius of the ball.

    To keep the pieces few, a piece is fitted up to the ball's next event, then up to later events.
    If the piece up to the next event doesn't fit, bisection finds a shorter piece. No piece
    contains a change of phase.
    """
    xyz = motion.positions[:, ball]
    # `<=` is false for nan.
    bad = np.flatnonzero(~(np.abs(xyz) <= FARTHEST).all(axis=1))
    known = int(bad[0]) if len(bad) else len(xyz)
    lost = None if known == len(xyz) else float(motion.times[known])
    if known == 0:
        nothing = np.zeros((0, 6), dtype=np.int64)
        three = nothing[:, :3]
        return ReplayTrack(nothing[:, 0], three, three, nothing, nothing[:, 0], lost)
    # One row for each coordinate, contiguous: the fits below are many and short.
    places = np.ascontiguousarray(xyz[:known].T)
    times = np.round(motion.times[:known] / tick) * tick
    ends = np.rint(places / QUANTUM)
    phases = (
        np.full(known, UNKNOWN_PHASE)
        if motion.phases is None
        else motion.phases[:known, ball].astype(np.int64)
    )
    at, bulges = [0], []
    spins = np.nan_to_num(motion.angular_velocities[:known, ball], posinf=0.0, neginf=0.0)
    path = _Path(times, places, ends * QUANTUM, np.ascontiguousarray(spins.T))
    stops = _stops(motion, ball, known, phases)
    while at[-1] < known - 1:
        start = at[-1]
        end, bulge = _longest_piece(path, start, stops)
        at.append(end)
        bulges.append(bulge)
    samples = np.array(at, dtype=np.int64)
    track = ReplayTrack(
        samples,
        ends[:, samples].T.astype(np.int64),
        np.array(bulges, dtype=np.int64).reshape(-1, 3),
        np.zeros((len(bulges), 6), dtype=np.int64),
        phases[samples[:-1]],
        lost,
    )
    return replace(track, spins=_spins_of(path, track, radius))


class _Path(NamedTuple):
    """Samples of one ball.

    `times` (k,) float64 [s]: rounded to ticks.
    `places` (3, k) float64 [m]: positions.
    `corners` (3, k) float64 [m]: positions rounded to `QUANTUM`, the ends of pieces.
    `spins` (3, k) float64 [rad/s].
    """

    times: FloatArray
    places: FloatArray
    corners: FloatArray
    spins: FloatArray

    def before(self, start: int, end: int) -> int:
        """Return the last sample of a piece before the event at its end."""
        return end - 1 if end - 1 > start and self.times[end - 1] == self.times[end] else end


def _spins_of(path: _Path, track: ReplayTrack, radius: float) -> IntArray:
    """Return the spins at the ends of the pieces minus rolling; see `ReplayTrack.spins`."""
    first, last = track.samples[:-1], track.samples[1:]
    before = [path.before(int(i), int(j)) for i, j in zip(first, last, strict=True)]
    dt = (path.times[last] - path.times[first])[:, np.newaxis]
    along = np.diff(track.ends, axis=0) * QUANTUM
    spins = []
    for at, sign in ((first, 1.0), (np.array(before, dtype=np.int64), -1.0)):
        displacement = along + sign * 4.0 * track.bulges * QUANTUM
        v = np.divide(displacement, dt, out=np.zeros_like(displacement), where=dt > 0.0)
        rolling = np.column_stack((-v[:, 1], v[:, 0], np.zeros(len(v)))) / radius
        spins.append(path.spins[:, at].T - rolling)
    return np.rint(np.hstack(spins) / SPIN_QUANTUM).astype(np.int64)


def _stops(motion: Motion, ball: int, known: int, phases: IntArray) -> tuple[IntArray, IntArray]:
    """Return the samples at which the ball's acceleration may change, and those of a new phase."""
    events = motion.events
    own = (events["a"] == ball) | ((events["b"] == ball) & (events["kind"] == 0))
    at = np.searchsorted(motion.times[:known], events["t"][own])
    hard = np.append(np.flatnonzero(np.diff(phases)) + 1, known - 1)
    return np.unique(np.concatenate((at[at < known], hard))), hard


def _longest_piece(
    path: _Path, start: int, stops: tuple[IntArray, IntArray]
) -> tuple[int, FloatArray]:
    soft, hard = stops
    last = int(hard[np.searchsorted(hard, start, side="right")])
    ahead = soft[np.searchsorted(soft, start, side="right") :]
    best: tuple[int, FloatArray] | None = None
    step = 0
    while step < len(ahead) and ahead[step] <= last:
        bulge = _fitted(path, start, int(ahead[step]))
        if bulge is None:
            break
        best = int(ahead[step]), bulge
        step = 2 * step + 1
    if best is not None:
        return best
    # Bisection starts from the next sample: a piece without samples inside always fits.
    low, high = start + 1, int(ahead[0])
    bulge = np.zeros(3)
    while high - low > 1:
        middle = (low + high) // 2
        fitted = _fitted(path, start, middle)
        low, high, bulge = (low, middle, bulge) if fitted is None else (middle, high, fitted)
    return low, bulge


def _fitted(path: _Path, start: int, end: int) -> FloatArray | None:
    """Return the bulge (3,) [`QUANTUM`] of the piece between two samples, or None if none fits.

    `start`, `end`: first and last sample of the piece.
    """
    if end - start < 2:
        return np.zeros(3)
    u = path.times[start : end + 1] - path.times[start]
    dt = u[-1]
    if dt == 0.0:
        return None
    u /= dt
    first, last = path.corners[:, start : start + 1], path.corners[:, end : end + 1]
    off = path.places[:, start : end + 1] - (first + u * (last - first))
    bow = 4.0 * u * (1.0 - u)
    # Samples within a tick of an end, for example just before an event, don't determine the bulge.
    weight = max(np.add.reduce(bow * bow), 1e-9)
    bulge: FloatArray = np.rint(np.add.reduce(bow * off, axis=1) / weight / QUANTUM)
    off -= bow * (bulge * QUANTUM)[:, np.newaxis]
    off *= off
    if not np.maximum.reduce(off[0] + off[1] + off[2]) <= TOLERANCE**2:
        return None
    # The replay interpolates the spin linearly from the start to the sample just before the end.
    before = path.before(start, end)
    spins, u = path.spins[:, start : before + 1], u[: before + 1 - start]
    straight = spins[:, :1] + u * (spins[:, -1:] - spins[:, :1])
    return bulge if np.max(np.abs(spins - straight)) * dt <= TURN_TOLERANCE else None


def packed_motion(
    motion: Motion, events: Events, radii: FloatArray
) -> tuple[bytes, float, dict[int, float]]:
    """Return a motion and its event log as bytes, the tick [s], and the time [s] of each lost ball.

    `events`, a structured array (`model.EVENT_DTYPE`): the events to keep.
    `radii` (n,) float64 [m]: radii of the balls.

    The bytes have this order:

    - the number of events; the bytes of their times (first all first bytes, then all second bytes,
      ..., because similar bytes compress better); their kinds, a and b;
    - the number of samples at which a piece of any ball starts or ends, and their times in ticks;
    - for each ball, the number of its own samples and their indices, then the phases, ends, bulges
      and spins of its pieces.

    Times in ticks, ball and sample indices, and ends are stored as the difference from the integer
    before. Kinds and phases are single bytes.
    """
    tick = tick_of(motion)
    tracks = [track_of(motion, ball, tick, radius) for ball, radius in enumerate(radii.tolist())]
    used = np.unique(np.concatenate([track.samples for track in tracks]))
    ticks = np.round(motion.times[used] / tick).astype(np.int64)
    planes = np.ascontiguousarray(events["t"], dtype="<f8").view(np.uint8).reshape(-1, 8).T
    parts = [
        packed([len(events)]),
        planes.tobytes(),
        events["kind"].astype(np.uint8).tobytes(),
        packed(_differences(events["a"])),
        packed(_differences(events["b"])),
        packed([len(used)]),
        packed(_differences(ticks)),
    ]
    for track in tracks:
        parts += [
            packed([len(track.samples)]),
            packed(_differences(np.searchsorted(used, track.samples))),
            track.phases.astype(np.uint8).tobytes(),
            *(packed(_differences(ends)) for ends in track.ends.T),
            *(packed(bulges) for bulges in track.bulges.T),
            *(packed(spins) for spins in track.spins.T),
        ]
    lost_at = {i: track.lost for i, track in enumerate(tracks) if track.lost is not None}
    return b"".join(parts), tick, lost_at


def packed(numbers: Iterable[int] | IntArray) -> bytes:
    """Return integers as bytes in zigzag code: seven bits in each byte, the lowest bits first."""
    values = np.asarray(numbers, dtype=np.int64)
    folded = ((values << 1) ^ (values >> 63)).view(np.uint64)
    sizes = np.ones(len(folded), dtype=np.int64)
    rest = folded >> np.uint64(7)
    while rest.any():
        sizes += rest != 0
        rest >>= np.uint64(7)
    out = np.zeros(int(sizes.sum()), dtype=np.uint8)
    place = np.cumsum(sizes) - sizes
    for k in range(int(sizes.max(initial=0))):
        here = sizes > k
        low = (folded[here] >> np.uint64(7 * k)) & np.uint64(127)
        more = (sizes[here] > k + 1).astype(np.uint64) << np.uint64(7)
        out[place[here] + k] = (low | more).astype(np.uint8)
    return out.tobytes()


def _differences(values: NDArray[np.integer]) -> IntArray:
    """Return the difference of each value from the value before; the first value is unchanged."""
    whole = values.astype(np.int64)
    return whole - np.concatenate(([0], whole[:-1]))[: len(whole)]
