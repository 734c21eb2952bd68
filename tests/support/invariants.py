"""What must hold in any run, checked from its recorded motion by brute force."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from engine import EventKind, Result, Scene

FloatArray = NDArray[np.float64]

EPS = 2.0**-52


def overlaps(scene: Scene, positions: FloatArray) -> FloatArray:
    """Return the deepest overlap of two balls, and of a ball with a cushion, at each of k instants.

    positions : (k, n, 3) [m]; returns (k, 2) [m], negative where everything is apart.
    """
    k, n, _ = positions.shape
    radii = scene.radii
    deepest = np.full((k, 2), -np.inf)
    for i in range(n):
        for j in range(i):
            apart = positions[:, i, :2] - positions[:, j, :2]
            distance = np.sqrt(np.sum(apart**2, axis=1))
            deepest[:, 0] = np.maximum(deepest[:, 0], radii[i] + radii[j] - distance)
        if scene.table is not None:
            x, y = positions[:, i, 0], positions[:, i, 1]
            beyond = {
                "left": radii[i] - x,
                "right": x + radii[i] - scene.table.length,
                "bottom": radii[i] - y,
                "top": y + radii[i] - scene.table.width,
            }
            for name in scene.table.cushions:
                deepest[:, 1] = np.maximum(deepest[:, 1], beyond[name])
    return deepest


def instants(result: Result, between: int = 7) -> FloatArray:
    """Return the times of all events and of `between` instants from each to the next, sorted."""
    assert result.events is not None
    marks = np.unique(np.concatenate(([0.0], result.events["t"], [result.rest_time])))
    parts = np.arange(between + 1) / (between + 1)
    inner = marks[:-1, np.newaxis] + np.diff(marks)[:, np.newaxis] * parts
    return np.append(inner.ravel(), marks[-1])


def energies(result: Result, times: FloatArray) -> FloatArray:
    """Return the total energy [J] at `times`, (k,)."""
    return result.energy(times).total


def ball_impacts(result: Result) -> Iterable[tuple[float, int, int]]:
    """Yield time and balls of each ball-ball collision that has its instant for itself."""
    events = result.events
    assert events is not None
    times, counts = np.unique(events["t"], return_counts=True)
    alone = set(times[counts == 1].tolist())
    for event in events:
        if event["kind"] == EventKind.BALL_BALL and float(event["t"]) in alone:
            yield float(event["t"]), int(event["a"]), int(event["b"])


def collisions(result: Result) -> list[tuple[int, int, int]]:
    """Return (kind, a, b) of every collision in order of time."""
    assert result.events is not None
    return [
        (int(event["kind"]), int(event["a"]), int(event["b"]))
        for event in result.events
        if event["kind"] in (EventKind.BALL_BALL, EventKind.BALL_CUSHION)
    ]


def state_bits(result: Result) -> tuple[bytes, ...]:
    """Return how the run ended, to the bit (0.0 and -0.0 are one value)."""
    arrays = (*result.final_state, np.array([result.rest_time]))
    return tuple((array + 0.0).astype("<f8").tobytes() for array in arrays)


def log_bits(result: Result) -> bytes:
    """Return the event log to the bit."""
    assert result.events is not None
    fields = (("t", "<f8"), ("kind", "u1"), ("a", "<i4"), ("b", "<i4"))
    return b"".join(result.events[name].astype(kind).tobytes() for name, kind in fields)


def fingerprint(result: Result) -> str:
    """Return the sha256 of the event log and the rest positions."""
    digest = hashlib.sha256(log_bits(result))
    digest.update((result.rest_positions + 0.0).astype("<f8").tobytes())
    return digest.hexdigest()
