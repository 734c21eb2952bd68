"""Outcomes of a shot, counted from its events: pocketed balls, first contact, cushions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ghostball.model.arrays import BoolArray, FloatArray, IntArray
from ghostball.model.events import EventKind, Events


class Outcomes(NamedTuple):
    """The outcomes of one shot of n balls, with the names of the arrays in `ghostball.Batch`."""

    pocketed: IntArray
    """Index of the pocket that each ball fell into, or -1, (n,) int64."""
    pocketed_at: FloatArray
    """When each ball fell into its pocket; NaN if it didn't, (n,) float64 [s]."""
    off_table: BoolArray
    """Whether each ball left the table other than into a pocket, (n,) bool."""
    first_contact: int
    """The first ball that the cue ball hits, or -1. If it hits several balls at the same time, this
    is the one whose event comes first."""
    cushions_before: int
    """Number of cushion collisions of the cue ball before its first contact; all of its cushion
    collisions if it hits no ball."""
    ball_cushions: IntArray
    """Number of cushion collisions of each ball, (n,) int64."""


def outcomes_of(events: Events, n: int, cue: int) -> Outcomes:
    """Return the outcomes of a shot of n balls from its events; `cue` is the cue ball's index."""
    kind, a, b = events["kind"], events["a"].astype(np.int64), events["b"].astype(np.int64)
    fell, off = kind == EventKind.POCKETED, kind == EventKind.LEAVES_TABLE
    bounces = kind == EventKind.BALL_CUSHION
    pocketed, pocketed_at = np.full(n, -1), np.full(n, np.nan)
    pocketed[a[fell]], pocketed_at[a[fell]] = b[fell], events["t"][fell]
    off_table = np.zeros(n, dtype=np.bool_)
    off_table[a[off]] = True
    hits = np.flatnonzero((kind == EventKind.BALL_BALL) & ((a == cue) | (b == cue)))
    first = int(hits[0]) if len(hits) else len(events)
    return Outcomes(
        pocketed=pocketed,
        pocketed_at=pocketed_at,
        off_table=off_table,
        first_contact=int(a[first] + b[first]) - cue if len(hits) else -1,
        cushions_before=int(np.count_nonzero(bounces[:first] & (a[:first] == cue))),
        ball_cushions=np.bincount(a[bounces], minlength=n),
    )
