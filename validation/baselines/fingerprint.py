"""A log too long to be kept event by event, block by block: hashes, and the instant of its end."""

from __future__ import annotations

from hashlib import sha256
from typing import NamedTuple

from ghostball.engine.result import Events
from ghostball.engine.result.hashes import log_bits, sequence_hash

BLOCK = 256
"""Events that share a hash."""

_DIGITS = 16
"""Hex digits that are kept of a hash."""


class Block(NamedTuple):
    """`BLOCK` events in a row, the last ones fewer.

    Hashes of all bits, and of their order alone; the instant of the last event [s], which later
    ones have carried on with the errors of all before.
    """

    bits: str
    sequence: str
    end: float


def blocks_of(events: Events) -> tuple[Block, ...]:
    """Return the log block by block."""
    parts = (events[start : start + BLOCK] for start in range(0, len(events), BLOCK))
    return tuple(
        Block(
            sha256(log_bits(part)).hexdigest()[:_DIGITS],
            sequence_hash(part)[:_DIGITS],
            float(part["t"][-1]),
        )
        for part in parts
    )
