"""Simulation of one shot: check the scene, run the kernel, return the result."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from ghostball.engine.running import calls, driver
from ghostball.engine.running.from_scene import admit
from ghostball.engine.running.skips import Skip, chosen_skips
from ghostball.engine.tangents import tangents_of
from ghostball.model import Result, Scene
from ghostball.model.errors import GhostballError
from ghostball.model.events import RECORDS, Record

MAX_EVENTS = 10_000_000
"""Default event limit: a shot has hundreds of events, a long run of an elastic gas millions."""

MAX_WORK = 10_000_000_000
"""Default work limit: a minute or two. A shot takes thousands, a long run of a gas 10^9."""

_LARGEST = 2**62
"""Largest limit that is accepted, because the kernels count in 64 bits."""


def simulate(
    scene: Scene,
    *,
    record: Record = "rest",
    max_events: int = MAX_EVENTS,
    max_work: int = MAX_WORK,
    no_skip: Collection[str] = (),
) -> Result:
    """Simulate `scene` in continuous time, to rest or to its `t_max`.

    Parameters
    ----------
    scene : Scene
    record : "rest", "events" or "trajectory"
        "rest" keeps only the final state. "events" keeps every event with its states, from which
        the motion can be sampled at any time; "trajectory" is the same for this engine.
    max_events : int
        Limit of events and contact steps, after which the run stops; `status` then says so.
    max_work : int
        Limit of work, after which the run stops: iterations of all loops, in units of about 6 ns.
        With this limit every run ends.
    no_skip : collection of str
        Skips that are switched off; `engine.running.skips` has their names. The result is the same,
        for "advancement" within rounding.

    Returns
    -------
    Result

    Raises
    ------
    UnsupportedSceneError
        If the scene needs physics that this engine lacks.
    SceneError
        If the scene was made without validation, and breaks a rule.
    GhostballError
        If `scene`, `record`, a limit or `no_skip` is invalid.
    KeyboardInterrupt
        On Ctrl-C, within a second. The unfinished shot is discarded, and a loop over shots ends. To
        get the first part of a long shot, set `t_max` or `max_work`.

    Notes
    -----
    Between events each ball moves in closed form, or in air along power series
    (`engine/motion/drag.py`); the next contact is the first time at which the exact gap
    closes (`engine/scheduling/all_pairs.py`). There is no time step, except for impacts that last
    (`engine/impacts/compliant.py`), and for balls that friction presses together: these move in
    steps that keep their gaps within a stated tolerance (`engine/resting_contact/step.py`), counted
    in `work["contact_steps"]`. Simultaneous impacts that share a ball, resolved together
    (`engine/impacts/simultaneous.py`), are counted in `work["joint_impacts"]`.

    The run ends when the last centre rests and the last spin about the vertical has decayed; a spin
    that no friction slows doesn't prolong the run.
    """
    check_request(scene, record, max_events, max_work)
    off = frozenset() if no_skip == () else chosen_skips(no_skip, scene)
    run = driver.KernelRun(scene, record != "rest" or Skip.RECORDS in off, off)
    driver.warm_up(run.variant)
    run.go(calls.Limits(max_events, max_work))
    settings: dict[str, int | str] = {"max_events": max_events}
    if max_work != MAX_WORK:
        settings["max_work"] = max_work
    if off:
        settings["no_skip"] = "+".join(sorted(off))
    trajectory = run.trajectory()
    result = Result(
        engine="ghostball",
        settings=settings,
        scene=scene,
        status=run.status,
        final_state=run.final_state(),
        rest_time=run.t_end,
        collision_counts=run.collision_counts(),
        work=run.work(),
        wall_time=run.wall_time,
        events=run.events(),
        trajectory=trajectory and replace(trajectory, tangents=tangents_of),
        reason=run.reason,
    )
    run.leave()
    return result


def check_request(scene: Scene, record: Record, max_events: int, max_work: int = MAX_WORK) -> None:
    """Raise if an argument of `simulate` is invalid, or this engine lacks what the scene needs."""
    if not isinstance(scene, Scene):
        raise GhostballError(
            f"`scene` must be a Scene, got {type(scene).__name__}. Read one with Scene.load(path)"
        )
    admit(scene)
    if record not in RECORDS:
        raise GhostballError(f"`record` must be one of {', '.join(RECORDS)}, got {record!r}")
    for name, limit in (("max_events", max_events), ("max_work", max_work)):
        if not isinstance(limit, int) or isinstance(limit, bool) or not 1 <= limit <= _LARGEST:
            raise GhostballError(f"`{name}` must be a whole number from 1 to 2^62, got {limit!r}")
