"""Distribution of shots to threads: a sweep, or one shot of each of many scenes."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from threading import Event

import numpy as np

from ghostball.engine.core import state as st
from ghostball.engine.core.block import END
from ghostball.engine.event_loop import play
from ghostball.engine.running.calls import Limits, Shots, memory_for, play_all
from ghostball.engine.running.driver import warm_up
from ghostball.engine.running.from_scene import SceneLayout, phases_of
from ghostball.model import Scene
from ghostball.model.scene.contents import rolling

_FEWEST_AT_ONCE, _MOST_AT_ONCE = 256, 2_048
"""Number of shots of one scene that a thread takes at a time: 1 to about 10 ms of work.

A thread allocates its arrays once for each share; with 256 shots this takes 0.2 us per shot.
"""

_SCENES_AT_ONCE = 64
"""Largest number of scenes per share: passing one scene at a time took as long as its simulation.
"""

_LISTENS = 0.2
"""Longest wait for the threads until Python looks for Ctrl-C [s].

Without a limit, Ctrl-C has no effect in a process that has imported polars: polars replaces
Python's signal handler by one after which the system continues the wait.
"""

Task = tuple[SceneLayout, st.IntArray]
"""Shots of one scene, as indices into `Shots`."""


def tasks_of(layout: SceneLayout, count: int, threads: int) -> list[list[Task]]:
    """Divide `count` shots of one scene into shares for a number of threads."""
    share = max(_FEWEST_AT_ONCE, min(_MOST_AT_ONCE, count // (4 * threads)))
    shares = np.array_split(np.arange(count), max(1, -(-count // share)))
    return [[(layout, which)] for which in shares]


def tasks_of_each(layouts: Sequence[SceneLayout], threads: int) -> list[list[Task]]:
    """Divide one shot of each scene into shares for a number of threads."""
    alone = np.arange(len(layouts)).reshape(-1, 1)
    tasks = list(zip(layouts, alone, strict=True))
    size = max(1, min(_SCENES_AT_ONCE, len(layouts) // (4 * threads)))
    return [tasks[k : k + size] for k in range(0, len(tasks), size)]


def run_tasks(
    shares: Sequence[Sequence[Task]], shots: Shots, limits: Limits, threads: int, *, who: int = 0
) -> None:
    """Simulate shots in threads, a share at a time, and put the results in `shots`.

    If `shots` has starts, they are those of ball `who` and the balls after it.

    After Ctrl-C or an error, each thread stops at its next return from the kernel.
    """
    for variant in {layout.variant for share in shares for layout, _ in share}:
        warm_up(variant)
    stop = Event()

    def play_share(share: Sequence[Task]) -> None:
        memory = np.empty(0)
        for layout, which in share:
            if len(memory) < layout.block.offsets[END]:
                memory = memory_for(layout)
            play_all(layout, memory, shots, which, limits, who=who, stop=stop)

    with ThreadPoolExecutor(threads) as pool:
        try:
            running = {pool.submit(play_share, share) for share in shares}
            while running:
                ended, running = wait(running, timeout=_LISTENS, return_when=FIRST_EXCEPTION)
                for one in ended:
                    one.result()
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
    """Return the initial states of balls in k shots for the kernel, (k, m, START_COLUMNS).

    `balls` (m,) are their indices in the scene; `given` (m,) is True if the spin is given, False if
    it is that of rolling. The other arrays are (k, m, 3) [m, m/s, rad/s].
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
