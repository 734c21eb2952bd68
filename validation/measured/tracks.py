"""Tracks: sampled positions of balls, of a real table from a file, or of an engine's run."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ghostball.model import GhostballError, Result
from ghostball.model.arrays import FloatArray
from ghostball.model.text_files import read_text

Shots = dict[str, dict[str, "Track"]]
"""The track of each ball of each shot, by their names in the file."""

HEADER = ("shot", "ball", "t", "x", "y")
"""Columns of a file of tracks."""

_FASTEST = 15.0
"""Speed that no ball reaches [m/s]; a faster step means that a tracker confused two balls."""
_LARGEST_OUTSIDE = 0.05
"""Largest distance of a tracked ball beyond the cushions [m]."""


class TracksError(GhostballError):
    """An invalid file of tracks: its name, the line, and the expected content."""


@dataclass(frozen=True)
class Track:
    """Positions of the centre of one ball: `times` (n,) [s], increasing; `positions` (n, 2) [m]."""

    times: FloatArray
    positions: FloatArray

    def at(self, times: FloatArray) -> FloatArray:
        """Return the positions at some times, (k, 2) [m], by linear interpolation."""
        columns = [np.interp(times, self.times, self.positions[:, axis]) for axis in (0, 1)]
        return np.column_stack(columns)

    def between(self, first: float, last: float) -> Track:
        """Return the samples from `first` to `last` [s]."""
        inside = (self.times >= first) & (self.times <= last)
        return Track(self.times[inside], self.positions[inside])


@dataclass(frozen=True)
class Surface:
    """The playing surface, with a corner as the origin: `length` along x, `width` along y [m]."""

    length: float
    width: float
    radius: float  # of the balls [m]

    def gaps(self, positions: FloatArray) -> FloatArray:
        """Return the gaps of a ball to the cushions at positions (..., 2), (..., 4) [m].

        The order is low x, high x, low y, high y.
        """
        far = np.array([self.length, self.width]) - positions
        sides = np.stack([positions, far], axis=-1) - self.radius
        return sides.reshape(*positions.shape[:-1], 4)

    def least_gaps(self, track: Track, others: Sequence[Track]) -> FloatArray:
        """Return the gap of a ball to the nearest cushion or ball, (n,) [m]."""
        gaps: FloatArray = np.min(self.gaps(track.positions), axis=1)
        for other in others:
            apart = np.linalg.norm(other.at(track.times) - track.positions, axis=1)
            gaps = np.minimum(gaps, apart - 2.0 * self.radius)
        return gaps


def dips(gaps: FloatArray, below: float) -> NDArray[np.bool_]:
    """Return which inner gaps are a local minimum below a limit."""
    inner = gaps[1:-1]
    found: NDArray[np.bool_] = (inner < below) & (inner <= gaps[:-2]) & (inner < gaps[2:])
    return found


def tracks_of(result: Result, rate: float = 50.0) -> dict[str, Track]:
    """Return the tracks that a camera with `rate` pictures per second sees of a recorded run."""
    times = np.arange(0.0, result.rest_time, 1.0 / rate)
    positions = result.sample(times).positions
    return {ball.id: Track(times, positions[:, i, :2]) for i, ball in enumerate(result.scene.balls)}


def read_tracks(
    path: Path, surface: Surface, columns: Mapping[str, str] | None = None, *, centred: bool = False
) -> Shots:
    """Return the tracks in a CSV file with the columns shot, ball, t, x, y.

    Times are in seconds, lengths in metres, and the origin is a corner of the playing surface.
    Lines that start with # are comments.

    `columns`: the file's names of these columns, if they differ, such as {"t": "time"}; the file
        may then have more columns, in any order.
    `centred`: whether the origin is the centre of the playing surface.

    Raises `TracksError` with the file, the line and the expected content.
    """
    samples: dict[str, dict[str, list[_Sample]]] = {}
    try:
        text = read_text(path)
    except (OSError, UnicodeDecodeError) as error:
        why = (error.strerror if isinstance(error, OSError) else "") or str(error)
        raise TracksError(f"{path}: can't read a CSV file of tracks in UTF-8: {why}") from error
    for where, row in _rows(path, text, columns):
        shot, ball, *numbers = row
        sample = _sample(where, numbers, surface, centred)
        track = samples.setdefault(shot, {}).setdefault(ball, [])
        if track:
            _check_step(where, ball, track[-1], sample)
        track.append(sample)
    if not samples:
        raise _refused(str(path), "samples below the header", "none")
    return {
        shot: {ball: _track(track) for ball, track in balls.items()}
        for shot, balls in samples.items()
    }


_Sample = tuple[float, float, float]
"""A time [s], and a position x, y [m]."""


def _track(samples: list[_Sample]) -> Track:
    table = np.array(samples)
    return Track(table[:, 0], table[:, 1:])


def _refused(where: str, expected: str, found: str) -> TracksError:
    return TracksError(f"{where}: expected {expected}, found {found}")


def _rows(
    path: Path, text: str, columns: Mapping[str, str] | None
) -> Iterator[tuple[str, list[str]]]:
    """Yield shot, ball, t, x and y of the rows below the header, with file and line number."""
    names = [(columns or {}).get(name, name) for name in HEADER]
    expected = f"the header {','.join(names)}" if columns is None else f"columns {', '.join(names)}"
    header: list[str] = []
    for number, line in enumerate(text.splitlines(), start=1):
        where = f"{path}:{number}"
        if not line.strip() or line.startswith("#"):
            continue
        try:
            row = [field.strip() for field in next(csv.reader([line]))]
        except csv.Error as error:
            most = csv.field_size_limit()
            found = f"a line of {len(line)}: {error}"
            raise _refused(where, f"fields of at most {most} characters", found) from None
        if header:
            if len(row) != len(header):
                raise _refused(where, f"{len(header)} fields", f"{len(row)}")
            yield where, [row[header.index(name)] for name in names]
        elif row == names or (columns is not None and all(row.count(name) == 1 for name in names)):
            header = row
        else:
            raise _refused(where, expected, f"{line.strip()!r:.100}")
    if not header:
        raise _refused(str(path), expected, "an empty file")


def _sample(where: str, numbers: list[str], surface: Surface, centred: bool) -> _Sample:
    try:
        t, x, y = map(float, numbers)
    except ValueError:
        raise _refused(where, "numbers as t, x and y", f"{', '.join(numbers):.100}") from None
    if not all(map(math.isfinite, (t, x, y))):
        raise _refused(where, "finite numbers as t, x and y", f"{', '.join(numbers):.100}")
    shifts = (0.5 * surface.length, 0.5 * surface.width) if centred else (0.0, 0.0)
    for name, value, low, extent in zip(
        "xy", (x, y), shifts, (surface.length, surface.width), strict=True
    ):
        if not -_LARGEST_OUTSIDE <= value + low <= extent + _LARGEST_OUTSIDE:
            hint = "; are the units centimetres or millimetres?" * (abs(value) > 10.0 * extent)
            hint = hint or "; is the origin the centre (--origin centre)?" * (
                value < 0.0 and not centred
            )
            expected = f"{name} between {0.0 - low:g} and {extent - low:g} m, the playing surface"
            raise _refused(where, expected, f"{value:g}{hint}")
    return t, x + shifts[0], y + shifts[1]


def _check_step(where: str, ball: str, before: _Sample, now: _Sample) -> None:
    """Refuse a time that decreases, and a step that is too fast for a ball."""
    step = now[0] - before[0]
    if step <= 0.0:
        expected = f"a time after {before[0]:g} s, the time of ball {ball}'s previous sample"
        raise _refused(where, expected, f"{now[0]:g} s")
    way = math.dist(now[1:], before[1:])
    if way > _FASTEST * step:
        expected = f"ball {ball} within {_FASTEST * step:.3g} m of its previous sample"
        found = f"a distance of {way:.3g} m: were two balls swapped?"
        raise _refused(where, expected, found)
