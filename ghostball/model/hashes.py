"""Hashes of what a run did: one of all bits, one of the order of its events alone.

Those of our engine are the same on every platform: what feeds back into the dynamics is made of
+ - * / and square roots.
"""

from __future__ import annotations

from hashlib import sha256
from typing import TYPE_CHECKING

from ghostball.model.arrays import FloatArray

if TYPE_CHECKING:
    from ghostball.model.events import Events

_TIME = (("t", "<f8"),)
_WHAT = (("kind", "u1"), ("a", "<i4"), ("b", "<i4"))


def bits_hash(events: Events, rest_positions: FloatArray) -> str:
    """Return the SHA-256 of an event log and the rest positions (n, 3) [m], to the bit.

    0.0 and -0.0 are one position.
    """
    digest = sha256(log_bits(events))
    digest.update((rest_positions + 0.0).astype("<f8").tobytes())
    return digest.hexdigest()


def log_bits(events: Events) -> bytes:
    """Return an event log as bytes: the same on every platform where its values are."""
    return _columns(events, _TIME + _WHAT)


def sequence_hash(events: Events) -> str:
    """Return the SHA-256 of what happened in which order: kinds and balls, without instants."""
    return sha256(_columns(events, _WHAT)).hexdigest()


def _columns(events: Events, columns: tuple[tuple[str, str], ...]) -> bytes:
    return b"".join(events[name].astype(kind).tobytes() for name, kind in columns)
