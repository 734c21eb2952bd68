"""Shots shared among threads: a sweep, or one shot of each of many scenes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from threading import Event
from typing import TypeVar

import numpy as np

from ghostball.engine.core import state as st
from ghostball.engine.event_loop import play
from ghostball.engine.running.driver import warm_up
from ghostball.engine.running.from_scene import Layout, layout_of, log_of, phases_of
from ghostball.engine.running.room import Limits, Room, Shots
from ghostball.model import Scene
from ghostball.model.scene.contents import rolling

_FEWEST_AT_ONCE, _MOST_AT_ONCE = 256, 2_048
"""Shots of a sweep that a thread takes at a time: one to some ten milliseconds'.

The arrays that each share needs are made once for it; with 256, that takes 0.2 us a shot.
"""

_SCENES_AT_ONCE = 64
"""Most scenes that a thread takes at a time: to hand over each alone took as long as to play it."""

_Part = TypeVar("_Part")


def run_sweep(scene: Scene, who: int, shots: Shots, limits: Limits, threads: int) -> None:
    """Play shots of one scene; what becomes of them is put in `shots`.

    They differ in how balls begin, the first of which is ball `who`.

    Interrupted by Ctrl-C, each thread stops when it has done its share of work.
    """
    layout, count = layout_of(scene), len(shots.counts)

    def play_part(part: st.IntArray, stop: Event) -> None:
        room, log = Room(layout), log_of(0, layout.count)
        first, continues = 0, False
        while first < len(part) and not stop.is_set():
            first = room.play(shots, part, first, continues, log, limits, who=who)
            continues = first < len(part) and shots.counts[part[first], st.STATUS] == st.RUN_PAUSED

    warm_up(layout.variant)
    share = max(_FEWEST_AT_ONCE, min(_MOST_AT_ONCE, count // (4 * threads)))
    parts = np.array_split(np.arange(count), max(1, -(-count // share)))
    _share(parts, play_part, threads)


def run_each(layouts: Sequence[Layout], shots: Shots, limits: Limits, threads: int) -> None:
    """Play one shot of each scene, as its layout has it; what becomes of them is put in `shots`.

    Interrupted by Ctrl-C, each thread stops when it has done its share of work.
    """
    for variant in {layout.variant for layout in layouts}:
        warm_up(variant)
    alone = list(np.arange(len(layouts)).reshape(-1, 1))
    log = log_of(0, 0)

    def play_part(part: range, stop: Event) -> None:
        room: Room | None = None
        for k in part:
            if stop.is_set():
                return
            layout = layouts[k]
            if room is None or not room.fits(layout):
                room = Room(layout)
            room.turn_to(layout)
            continues = False
            while not stop.is_set():
                room.play(shots, alone[k], 0, continues, log, limits)
                if shots.counts[k, st.STATUS] != st.RUN_PAUSED:
                    break
                continues = True

    size = max(1, min(_SCENES_AT_ONCE, len(layouts) // (4 * threads)))
    parts = [range(k, min(k + size, len(layouts))) for k in range(0, len(layouts), size)]
    _share(parts, play_part, threads)


def _share(parts: Sequence[_Part], play_part: Callable[[_Part, Event], None], threads: int) -> None:
    """Have threads play parts of many shots; an event tells them to stop, at Ctrl-C or an error."""
    stop = Event()
    with ThreadPoolExecutor(threads) as pool:
        try:
            for done in [pool.submit(play_part, part, stop) for part in parts]:
                done.result()
        except BaseException:
            stop.set()
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def rows_of_starts(
    scene: Scene,
    balls: st.IntArray,
    positions: st.FloatArray,
    velocities: st.FloatArray,
    spins: st.FloatArray,
    given: st.BoolArray,
) -> st.FloatArray:
    """Return how balls begin in k shots, as the kernel takes it: (k, m, START_COLUMNS).

    `balls` (m,) are their indices in the scene, `given` (m,) says whose spin is given and not that
    of rolling; the others are (k, m, 3) [m, m/s, rad/s].
    """
    radii, slides = scene.radii[balls], scene.physics.motion == "sliding"
    rise = positions[:, :, 2] - radii
    rolls = np.ones(rise.shape, dtype=np.bool_)
    if slides and np.any(given):
        rolls = ~given | rolling(velocities, spins, radii)
    rows = np.empty((*rise.shape, play.START_COLUMNS))
    rows[:, :, play.START_X : play.START_RISE] = positions[:, :, :2]
    rows[:, :, play.START_RISE] = rise
    rows[:, :, play.START_VX : play.START_WX] = velocities
    rows[:, :, play.START_WX : play.START_PHASE] = spins
    rises = (rise > 0.0) | (velocities[:, :, 2] > 0.0)
    rows[:, :, play.START_PHASE] = phases_of(rolls, rises, slides)
    return rows
