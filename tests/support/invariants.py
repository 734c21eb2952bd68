"""What must hold in any run, checked from its recorded motion by brute force."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ghostball.engine import EventKind, Result
from ghostball.engine.result import hashes
from ghostball.validation.stress.judges import FloatArray, energies, instants, overlaps

__all__ = [
    "EPS",
    "FloatArray",
    "ball_impacts",
    "collisions",
    "energies",
    "fingerprint",
    "instants",
    "log_bits",
    "overlaps",
    "state_bits",
]

EPS = 2.0**-52


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
    return hashes.log_bits(result.events)


def fingerprint(result: Result) -> str:
    """Return the sha256 of the event log and the rest positions."""
    assert result.events is not None
    return hashes.bits_hash(result.events, result.rest_positions)
