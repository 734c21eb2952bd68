"""Runs a sweep, many shots of one scene that differ in one ball's motion: shared among threads."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

import numpy as np

from ghostball.engine.core import state as s
from ghostball.engine.core.kernel import compiling
from ghostball.engine.event_loop.sweep import Shots, sweep
from ghostball.engine.running.driver import events_at_once
from ghostball.engine.running.from_scene import Layout, contacts_of, layout_of, log_of
from ghostball.engine.running.variants import Variant, still_scene, variant_of
from ghostball.engine.scene import Scene

_SHARE = 256
"""Shots of a sweep that a thread takes at a time: about a millisecond's."""


def run_sweep(scene: Scene, cue: int, shots: Shots, max_events: int, threads: int) -> None:
    """Simulate shots of ball `cue` of one scene; the results are put in `shots`.

    Those that turn out to need contacts are done again, with them. Interrupted by Ctrl-C, each
    thread stops after some events more.
    """
    layout = layout_of(scene)
    pending = np.arange(len(shots.status))
    stop = np.zeros(1, dtype=np.bool_)

    def simulate_part(part: s.IntArray, with_contacts: bool) -> None:
        at_once = events_at_once(len(layout.radii), with_contacts)
        sweep(part, cue, shots, max_events, at_once, stop, *_room(layout, with_contacts))

    for with_contacts in (False, True):
        if len(pending) == 0:
            break
        _warm_up(variant_of(scene, with_contacts))
        with ThreadPoolExecutor(threads) as pool:
            parts = np.array_split(pending, -(-len(pending) // _SHARE))
            try:
                for done in [pool.submit(simulate_part, part, with_contacts) for part in parts]:
                    done.result()
            except KeyboardInterrupt:
                stop[0] = True
                pool.shutdown(wait=True, cancel_futures=True)
                raise
        pending = np.flatnonzero(shots.status == s.RUN_CONTACTS)


@cache
def _warm_up(variant: Variant) -> None:
    """Compile a variant of the kernel of sweeps, or load it."""
    scene = still_scene(variant)
    with compiling(variant.name("sweeps")):
        none = shots_of(0, len(scene.balls))
        stop = np.zeros(1, dtype=np.bool_)
        sweep(np.arange(0), 0, none, 1, 1, stop, *_room(layout_of(scene), variant.contacts))


def shots_of(k: int, n: int) -> Shots:
    """Room for k shots of a scene of n balls."""
    return Shots(
        velocity=np.zeros((k, 2)),
        spin=np.zeros((k, 3)),
        slides=np.zeros(k, dtype=np.bool_),
        status=np.full(k, s.RUN_CONTACTS),
        rest_time=np.zeros(k),
        rest=np.zeros((k, n, 3)),
        counts=np.zeros((k, 3), dtype=np.int64),
        farthest=np.zeros(k),
    )


def _room(layout: Layout, with_contacts: bool) -> tuple[Any, ...]:
    """Room for a thread to work in: the last arguments of `sweep`."""
    n = len(layout.radii)
    air = layout.balls.air
    balls = s.Balls._make(
        None if array is None else np.empty_like(array) for array in layout.balls._replace(air=None)
    )._replace(air=air and s.Air._make(np.empty_like(array) for array in air))
    pairs = s.Pairs._make(np.empty_like(array) for array in layout.pairs)
    cells = layout.cells and s.Cells._make(array.copy() for array in layout.cells)
    contacts = contacts_of(n) if with_contacts else None
    start, end = layout.balls.state, np.empty((3, n, 3))
    laws = (layout.laws, layout.obstacles, layout.integrated)
    return (start, *laws, balls, pairs, cells, contacts, log_of(0, n), end)
