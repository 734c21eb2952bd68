"""The result of any engine: rest positions, events, counts, samples, energy, and run time."""

from __future__ import annotations

import json
import math
import traceback
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ghostball.model.arrays import BoolArray, FloatArray
from ghostball.model.errors import EngineFailedError, GhostballError
from ghostball.model.events import LEAVING_KINDS, OBSTACLE_KINDS, EventKind, Events, Status
from ghostball.model.hashes import bits_hash
from ghostball.model.outcomes import Outcomes, outcomes_of
from ghostball.model.scene.continuation import fields_at, gone_by_place
from ghostball.model.scene.obstacles import partner_name
from ghostball.model.scene.scene import Scene, made_after
from ghostball.model.strokes import struck_balls
from ghostball.model.trajectory.tangent_map import TangentMap
from ghostball.model.trajectory.trajectory import (
    Energy,
    ExactTrajectory,
    SampledTrajectory,
    Samples,
    Trajectory,
    energy_of,
)
from ghostball.model.views import view_of


@dataclass(frozen=True, eq=False, init=False)
class Result:
    """The result of one scene on one engine.

    Attributes
    ----------
    engine : str
        Name of the engine.
    settings : mapping of str to str, int, float or bool
        Settings of the engine at the time of the run, frozen.
    scene : Scene
    status : Status
    final_state : Samples, arrays (1, n, 3)
        State of every ball at the end of the run; at rest if `status` is REST.
    rest_time : float [s]
        Time at which the last ball came to rest, or at which the run stopped.
    collision_counts : mapping of str to int
        Number of collisions by kind, "ball-ball" and "ball-cushion".
    work : mapping of str to int
        Machine-independent counters: events, bounds, steps ...
    wall_time : float [s]
        Run time of the simulation, without building the world or compiling.
    engine_time : float [s] or None
        The part of `wall_time` in a time-stepping engine's own steps; the adapter takes the rest.
        None if it was not measured.
    events : structured array (`EVENT_DTYPE`) in order of time, or None
        None if `record="rest"`.
    trajectory : Trajectory or None
        None if no motion was recorded. Samples continue until the run ends, or until all balls on
        the table rest.
    reason : str
        Why the run stopped early, or "".
    """

    engine: str
    settings: Mapping[str, Any]
    scene: Scene
    status: Status
    final_state: Samples
    rest_time: float
    collision_counts: Mapping[str, int]
    work: Mapping[str, int]
    wall_time: float
    events: Events | None = None
    trajectory: Trajectory | None = field(default=None, repr=False)
    reason: str = ""
    engine_time: float | None = None

    def __init__(
        self,
        engine: str,
        settings: Mapping[str, Any],
        scene: Scene,
        status: Status,
        final_state: Samples,
        rest_time: float,
        collision_counts: Mapping[str, int],
        work: Mapping[str, int],
        wall_time: float,
        events: Events | None = None,
        trajectory: Trajectory | None = None,
        reason: str = "",
        engine_time: float | None = None,
    ) -> None:
        # The constructor of a frozen dataclass sets each field by a call. The kernel needs
        # only a few microseconds for a shot of two balls, so these calls would count.
        vars(self).update(
            engine=engine,
            settings=settings,
            scene=scene,
            status=status,
            final_state=final_state,
            rest_time=rest_time,
            collision_counts=collision_counts,
            work=work,
            wall_time=wall_time,
            events=events,
            trajectory=trajectory,
            reason=reason,
            engine_time=engine_time,
        )

    def __repr__(self) -> str:
        """Return the most important values of the result in a few lines, without arrays."""
        counts = ", ".join(f"{count} {kind}" for kind, count in self.collision_counts.items())
        events = "not recorded" if self.events is None else str(len(self.events))
        motion = "not recorded" if self.trajectory is None else type(self.trajectory).__name__
        reason = f", reason={self.reason!r}" if self.reason else ""
        return (
            f"<Result of scene {self.scene.name!r} ({len(self.scene.balls)} balls) on engine "
            f"{self.engine!r}: status={self.status.name}{reason}, rest_time={self.rest_time:.6g} "
            f"s, collisions: {counts or 'none'}; events: {events}; trajectory: {motion}>"
        )

    @property
    def rest_positions(self) -> FloatArray:
        """Centres of the balls at the end of the run, (n, 3) float64 [m]."""
        positions: FloatArray = self.final_state.positions[0]
        return positions

    @property
    def gone(self) -> BoolArray:
        """Which balls were pocketed or left the table, (n,) bool.

        Determined from the events, or, in a result without events, from the rest positions.
        """
        return self._gone_by(math.inf, self.rest_positions)

    def outcomes(self, cue: int | str = 0) -> Outcomes:
        """Return which balls were pocketed, and where; the first contact; and cushion collisions.

        Parameters
        ----------
        cue : int or str
            Index or id of the cue ball, for `first_contact` and `cushions_before`.

        Returns
        -------
        Outcomes
            The names are those of the arrays in `Batch`.

        Raises
        ------
        GhostballError
            If the run recorded no events, or if there is no ball `cue`.
        """
        if self.events is None:
            raise GhostballError(
                f"no events were recorded: engine `{self.engine}` ran without "
                'record="events". Call simulate(scene, record="events")'
            )
        return outcomes_of(self.events, len(self.scene.balls), self.scene.index_of(cue, "cue"))

    def at(self, t: float, *, name: str | None = None) -> Scene:
        """Return the scene at time `t`: simulating this scene continues the shot.

        Its balls have the positions, velocities and angular velocities of time `t`. Balls that were
        pocketed or left the table by then are removed. Its `t_max` is the remaining time; if no
        time remains, it is the `t_max` of the original scene. It has no title and no tags.

        Parameters
        ----------
        t : float [s]
            From 0 to `rest_time`; if the balls are at rest then, any later time, too.
        name : str, optional
            Name of the new scene; None keeps the name of the original scene.

        Returns
        -------
        Scene

        Raises
        ------
        GhostballError
            If the run recorded no motion, or if `t` is before the start, or after the end of a run
            that stopped before its balls rested.
        SceneError
            If no ball is left, or if the state breaks a rule of scenes. If balls overlap, the error
            names the balls and the overlap [m]; no ball is moved.

        Notes
        -----
        Ghostball's engine treats all bounces on the table that are lower than 3e-9 m as one motion,
        which lasts at most a few milliseconds. During this motion, the vertical speed of the ball
        isn't known. A ball that lies on other balls bounces there, by less than 1e-6 m; these
        bounces differ in the new scene.
        """
        instants = _instants(t, "t")
        if len(instants) != 1:
            raise GhostballError(f"`t` must be one time, got {len(instants)}")
        state, t = self.sample(instants), float(instants[0])
        if t > self.rest_time and self.status is not Status.REST:
            raise GhostballError(
                f"`t` must be at most {self.rest_time:.9g} s, where the run stopped before its "
                f"balls rested, got {t:.9g} s. Give an earlier time, or simulate for longer"
            )
        scene, gone = self.scene, self._gone_by(t, state.positions[0])
        fields = fields_at(scene, t, [array[0] for array in state], gone)
        return made_after(lambda: Scene(name=name or scene.name, **fields), self.engine)

    def sample(self, times: ArrayLike) -> Samples:
        """Return positions, velocities and angular velocities at `times`, each (k, n, 3).

        Parameters
        ----------
        times : (k,) float64 [s]
            In any order, from 0; after the end, the final state is returned.

        Raises
        ------
        GhostballError
            If the run recorded no motion, or if a time is negative or NaN.
        EngineFailedError
            If the engine returned its own trajectory type, and sampling it fails or returns invalid
            states.
        """
        t, trajectory = _instants(times), self._recorded()
        if type(trajectory) in (ExactTrajectory, SampledTrajectory):
            return trajectory.sample(t)
        return _sampled_by(self.engine, trajectory, t, len(self.scene.balls))

    def energy(self, times: ArrayLike) -> Energy:
        """Return the total energy at `times` [J], split into translation, rotation and height.

        Parameters and errors are those of `sample`.
        """
        return energy_of(self.scene, self.sample(times))

    def orientation(self, times: ArrayLike) -> FloatArray:
        """Return the orientation of every ball at `times`: unit quaternions (k, n, 4), w first.

        Parameters are those of `sample`; every ball starts at (1, 0, 0, 0). For an engine that
        records frames, the angular velocities of the frames are interpolated linearly and
        integrated.

        Raises
        ------
        GhostballError
            If the run recorded no motion, or if the engine returned its own trajectory type.
        """
        t, trajectory = _instants(times), self._recorded()
        if isinstance(trajectory, (ExactTrajectory, SampledTrajectory)):
            return trajectory.orientation(t)
        raise GhostballError(
            f"engine `{self.engine}` returned its own trajectory type, which has no orientation"
        )

    def phases(self, times: ArrayLike) -> NDArray[np.int8]:
        """Return how every ball moves at `times`: `Phase` as (k, n) int8.

        Parameters are those of `sample`. At the time of an event, the phase after the event is
        returned.

        Raises
        ------
        GhostballError
            If the run recorded no motion, or if the engine records frames instead of exact motion.
            A frame has no phase, because it can't distinguish slip from the rounding of the engine.
        """
        return self._exact("phases").phases(_instants(times))

    def sensitivity(self, times: ArrayLike) -> FloatArray:
        """Return the displacement of each ball by rounding, over 2^-53: (k, n) float64 [m].

        This is the rms displacement, to first order, if the state is rounded once at the start and
        at each event. Values that are exactly 0 by symmetry stay 0, as in Ghostball's engine; use
        `tangent` for perturbations without that symmetry. The result is infinite after simultaneous
        collisions of one ball and after resting contact, where no derivative exists. See
        `engine.sensitivity`.

        Parameters are those of `sample`.

        Raises
        ------
        GhostballError
            If the run recorded no motion, or if the engine records frames instead of exact motion.
        """
        return self.rounding.growth(_instants(times))

    def horizon(self, tolerance: float = 1e-3, error: float | None = None) -> float:
        """Return the predictability horizon [s]: until then, errors stay within a tolerance.

        Parameters
        ----------
        tolerance : float [m]
        error : float, optional
            Relative size of the error made at the start and at each event; default: 32 roundings,
            the guaranteed bound of Ghostball's engine.

        Returns
        -------
        float [s]
            The first time at which `error` times `sensitivity` exceeds the tolerance for a ball;
            inf if there is none.

        Raises
        ------
        GhostballError
            As `sensitivity`; or if an argument isn't a positive number.
        """
        for name, value in (("tolerance", tolerance), ("error", error)):
            if value is not None and not (math.isfinite(value) and value > 0.0):
                raise GhostballError(f"`{name}` must be a positive number, got {value!r}")
        events = self._exact_events("horizon")
        instants = np.unique(np.append(0.0, events["t"]))
        return self.rounding.horizon(instants, tolerance, error)

    def tangent(self, directions: ArrayLike) -> TangentMap:
        """Return the effect of small changes of the initial state on the shot, to first order.

        See `engine.sensitivity.tangent_of`.

        Parameters
        ----------
        directions : (m, n, 7) float64
            Each row is a change of every ball's position x, y [m], velocity x, y [m/s] and angular
            velocity x, y, z [rad/s].

        Raises
        ------
        GhostballError
            As `sensitivity`; or if `directions` has a wrong shape or isn't finite.
        """
        return self._tangents("tangent map", directions)

    def to_dict(self) -> dict[str, Any]:
        """Return the result as plain values, as printed by `ghostball run --format json`."""
        end = energy_of(self.scene, self.final_state)
        return {
            "engine": self.engine,
            "settings": dict(self.settings),
            "scene": self.scene.name,
            "strikes": [struck.to_dict() for struck in struck_balls(self.scene)],
            "status": self.status.name.lower().replace("_", "-"),
            "reason": self.reason,
            "rest_time": self.rest_time,
            "rest_positions": self.rest_positions.tolist(),
            "events": None if self.events is None else [event_dict(e) for e in self.events],
            "collision_counts": dict(self.collision_counts),
            "energy": {"initial": first_energy(self.scene), "final": float(end.total[0])},
            "work": dict(self.work),
            "hash": None if self.events is None else bits_hash(self.events, self.rest_positions),
            "wall_time": self.wall_time,
            "engine_time": self.engine_time,
        }

    def to_json(self) -> str:
        """Return `to_dict` as one line of JSON; floats are read back with the same bits.

        JSON has no NaN or infinity: null stands for both, for example if an engine diverged.
        """
        return json.dumps(_finite(self.to_dict()), allow_nan=False)

    def _repr_html_(self) -> str | None:
        """Return the picture for a notebook: the end of the shot and the paths of the balls."""
        return view_of(self)

    @cached_property
    def rounding(self) -> TangentMap:
        """Effect of rounding the state at each event; errors as `sensitivity`."""
        return self._tangents("sensitivity", None)

    def __getstate__(self) -> dict[str, Any]:
        # `rounding` is as large as the motion and is recomputed if needed. In interpreted runs it
        # contains views of memory, which can't be sent to another process.
        return {name: value for name, value in vars(self).items() if name != "rounding"}

    def _tangents(self, wanted: str, directions: ArrayLike | None) -> TangentMap:
        trajectory, events = self._exact(wanted), self._exact_events(wanted)
        if trajectory.tangents is None:
            raise GhostballError(
                f"engine `{self.engine}` provides no {wanted}; engine `ghostball` does"
            )
        return trajectory.tangents(self.scene, trajectory, events, directions)

    def _gone_by(self, t: float, positions: FloatArray) -> BoolArray:
        """Return which balls have left the table by `t` [s], (n,), given their `positions` then."""
        if self.events is None:
            return gone_by_place(self.scene, positions)
        gone = np.zeros(len(self.scene.balls), dtype=np.bool_)
        left = np.isin(self.events["kind"], LEAVING_KINDS) & (self.events["t"] <= t)
        gone[self.events["a"][left]] = True
        return gone

    def _exact_events(self, wanted: str) -> Events:
        """Return the events of a run that recorded exact motion."""
        self._exact(wanted)
        assert self.events is not None  # events are recorded with every motion
        return self.events

    def _recorded(self) -> Trajectory:
        if self.trajectory is None:
            raise GhostballError(
                f'no motion was recorded: engine `{self.engine}` ran without record="trajectory". '
                'Call simulate(scene, record="trajectory")'
            )
        return self.trajectory

    def _exact(self, wanted: str) -> ExactTrajectory:
        trajectory = self._recorded()
        if not isinstance(trajectory, ExactTrajectory):
            raise GhostballError(
                f"engine `{self.engine}` records frames, which have no {wanted}; engine "
                "`ghostball` records exact motion"
            )
        return trajectory


def _sampled_by(engine: str, trajectory: Trajectory, times: FloatArray, n: int) -> Samples:
    """Sample a trajectory of the engine's own type; errors count as failures of the engine."""
    try:
        samples = Samples(*trajectory.sample(times))
    except (Exception, SystemExit) as error:
        reason = f"`trajectory.sample` raised {type(error).__name__}: {error}"
        trace = "".join(traceback.format_exception(error))
        raise EngineFailedError(engine, reason, trace) from error
    wanted = (len(times), n, 3)
    for name, array in samples._asdict().items():
        if not isinstance(array, np.ndarray) or array.dtype.kind != "f" or array.shape != wanted:
            got = getattr(array, "shape", type(array).__name__)
            raise EngineFailedError(
                engine,
                f"`trajectory.sample` must return {name} as floats of shape {wanted}, got {got}",
            )
    return samples


def _instants(times: ArrayLike, name: str = "times") -> FloatArray:
    """Return `times` as a checked array (k,); error messages call the parameter `name`."""
    try:
        given = np.asarray(times)
        t = np.atleast_1d(given.astype(np.float64))
    except (TypeError, ValueError):
        given = np.asarray(None)
    # numpy converts None to NaN, and texts to numbers.
    if given.dtype.kind not in "biuf" and (given.dtype.kind != "O" or None in given.ravel()):
        raise GhostballError(
            f"`{name}` must be numbers of seconds, got {repr(times)[:80]}. "
            "Give times from 0 to `rest_time`"
        )
    if t.ndim != 1:
        raise GhostballError(f"`{name}` must be one-dimensional, got shape {t.shape}")
    wrong = t[~(t >= 0.0)]
    if len(wrong):
        raise GhostballError(f"`{name}` must be at least 0 s, got {wrong[0]}; shots start at t = 0")
    return t


def _finite(value: Any) -> Any:
    """Return `value` with None in place of every number that isn't finite."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def initial_state(scene: Scene) -> Samples:
    """Return the state of every ball at t = 0, arrays of shape (1, n, 3)."""
    return Samples(
        scene.positions[np.newaxis],
        scene.velocities[np.newaxis],
        scene.angular_velocities[np.newaxis],
    )


def first_energy(scene: Scene) -> float:
    """Return the initial energy of a shot [J], before any collisions at t = 0."""
    return float(energy_of(scene, initial_state(scene)).total[0])


def event_dict(event: Any) -> dict[str, Any]:
    """Return an event as plain values: `b` is a ball index, the name of an obstacle, or None."""
    kind = EventKind(int(event["kind"]))
    b: int | str | None = int(event["b"])
    if kind in OBSTACLE_KINDS:
        b = partner_name(kind, int(event["b"]))
    elif kind is not EventKind.BALL_BALL:
        b = None
    return {"t": float(event["t"]), "kind": kind.label, "a": int(event["a"]), "b": b}
