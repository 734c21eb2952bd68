"""Shots shared among threads: a sweep, or one shot of each of many scenes."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from threading import Event

import numpy as np

from ghostball.engine.core import state as st
from ghostball.engine.event_loop import play
from ghostball.engine.running.driver import warm_up
from ghostball.engine.running.from_scene import Layout, phases_of
from ghostball.engine.running.room import Limits, Room, Shots
from ghostball.model import Scene
from ghostball.model.scene.contents import rolling

_FEWEST_AT_ONCE, _MOST_AT_ONCE = 256, 2_048
"""Shots of one scene that a thread takes at a time: one to some ten milliseconds of work.

A thread makes the arrays that it works in once for each share; with 256, that takes 0.2 us a shot.
"""

_SCENES_AT_ONCE = 64
"""Most scenes that a thread takes at a time: to hand over each alone took as long as to play it."""

Task = tuple[Layout, st.IntArray]
"""Shots of one scene, by their places in `Shots`."""


def tasks_of(layout: Layout, count: int, threads: int) -> list[list[Task]]:
    """Return `count` shots of one scene in shares for a number of threads."""
    share = max(_FEWEST_AT_ONCE, min(_MOST_AT_ONCE, count // (4 * threads)))
    shares = np.array_split(np.arange(count), max(1, -(-count // share)))
    return [[(layout, which)] for which in shares]


def tasks_of_each(layouts: Sequence[Layout], threads: int) -> list[list[Task]]:
    """Return one shot of each scene in shares for a number of threads."""
    alone = np.arange(len(layouts)).reshape(-1, 1)
    tasks = list(zip(layouts, alone, strict=True))
    size = max(1, min(_SCENES_AT_ONCE, len(layouts) // (4 * threads)))
    return [tasks[k : k + size] for k in range(0, len(tasks), size)]


def run_tasks(
    shares: Sequence[Sequence[Task]], shots: Shots, limits: Limits, threads: int, *, who: int = 0
) -> None:
    """Play shots in threads, a share at a time; what becomes of them is put in `shots`.

    Where `shots` has starts, these are of ball `who` and those that follow.

    Interrupted by Ctrl-C, or by an error, each thread stops when it has done its share of work.
    """
    for variant in {layout.variant for share in shares for layout, _ in share}:
        warm_up(variant)
    stop = Event()

    def play_share(share: Sequence[Task]) -> None:
        room: Room | None = None
        for layout, which in share:
            if room is None or not room.fits(layout):
                room = Room(layout)
            room.turn_to(layout)
            room.play_all(shots, which, limits, who=who, stop=stop)

    with ThreadPoolExecutor(threads) as pool:
        try:
            for done in [pool.submit(play_share, share) for share in shares]:
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
