"""Hashes of a result: one of all its bits, and one of the order of its events.

The hashes of Ghostball's engine are the same on every platform: everything that affects the motion
is computed with + - * / and square roots.
"""

from __future__ import annotations

from hashlib import sha256
from typing import TYPE_CHECKING

from ghostball.model.arrays import FloatArray

if TYPE_CHECKING:
    from ghostball.model.events import Events

_TIME_COLUMN = (("t", "<f8"),)
_KIND_AND_BODY_COLUMNS = (("kind", "u1"), ("a", "<i4"), ("b", "<i4"))


def bits_hash(events: Events, rest_positions: FloatArray) -> str:
    """Return the SHA-256 hash of the bits of an event log and the rest positions (n, 3) [m].

    0.0 and -0.0 count as the same position.
    """
    digest = sha256(log_bits(events))
    digest.update((rest_positions + 0.0).astype("<f8").tobytes())
    return digest.hexdigest()


def log_bits(events: Events) -> bytes:
    """Return an event log as bytes; equal values give equal bytes on every platform."""
    return _columns(events, _TIME_COLUMN + _KIND_AND_BODY_COLUMNS)


def sequence_hash(events: Events) -> str:
    """Return the SHA-256 hash of the order of the events: kinds and balls, without times."""
    return sha256(_columns(events, _KIND_AND_BODY_COLUMNS)).hexdigest()


def _columns(events: Events, columns: tuple[tuple[str, str], ...]) -> bytes:
    return b"".join(events[name].astype(kind).tobytes() for name, kind in columns)
