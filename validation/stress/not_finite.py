"""Trials of numbers that are none: past the checks of a scene, made by a kernel, or by overflow."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from engine import Ball, Physics, Scene, SceneError, Status, Table
from engine.core import state
from engine.running.driver import Run
from reference_adapters import ReferenceEngine
from validation.playing import blamed_on_engine
from validation.stress.trial import Trial, Verdict

_FIELDS: tuple[tuple[str, int | None], ...] = (
    *((field, axis) for field in ("position", "velocity", "angular_velocity") for axis in range(3)),
    ("radius", None),
    ("mass", None),
    ("rolling_friction", None),
    ("sliding_friction", None),
    ("spinning_friction_rate", None),
)
"""Numbers of a ball, and the component of those that are vectors."""

_LAWS = tuple(name for name, value in Physics() if isinstance(value, float))
"""Coefficients of the physics."""

UNCHECKED = {
    "rolling": Physics(),
    "sliding": Physics(preset="pool"),
    "integrated": Physics(preset="pool", ball_impact="mathavan2014", cushion="mathavan2010"),
}


def unchecked_base(physics: Physics, count: int) -> Scene:
    """Return a shot in order, in which everything happens: two balls meet, and the cushions."""
    cue = Ball(id="cue", position=(0.3, 0.3), velocity=(1.0, 0.1))
    others = [
        Ball(id=f"b{k}", position=(0.5 + 0.07 * (k % 15), 0.1 + 0.07 * (k // 15)))
        for k in range(count - 1)
    ]
    return Scene(
        name="unchecked",
        physics=physics,
        table=Table(length=2.0, width=1.0),
        t_max=0.5,
        balls=[cue, *others],
    )


def spoilt(base: Scene, value: float) -> Iterator[tuple[str, Scene]]:
    """Yield `base` spoilt past the checks, and what the refusal must say.

    Each of its numbers in turn is replaced; and in one scene all balls lie at one place, more of
    them touching than the kernels have room for.
    """
    for i in (0, len(base.balls) - 1):
        ball = base.balls[i]
        for field, axis in _FIELDS:
            planted: Any = value
            if axis is not None:
                vector = list(getattr(ball, field) or (0.0, 0.0, 0.0))
                vector[axis] = value
                planted = tuple(vector)
            balls = list(base.balls)
            balls[i] = ball.model_copy(update={field: planted})
            where = f"balls[{i}].{field}" + ("" if axis is None else f"[{axis}]")
            yield f"`{where}`", base.model_copy(update={"balls": tuple(balls)})
    for field in _LAWS:
        physics = base.physics.model_copy(update={field: value})
        yield f"`physics.{field}`", base.model_copy(update={"physics": physics})
    for field in ("length", "width"):
        assert base.table is not None
        table = base.table.model_copy(update={field: value})
        yield f"`table.{field}`", base.model_copy(update={"table": table})
    yield "`t_max`", base.model_copy(update={"t_max": value})
    heap = [
        ball.model_copy(
            update={
                "position": (0.5 + 1e-4 * k, 0.5, ball.radius),
                "velocity": (-1.0 * k, 0.0, 0.0),
            }
        )
        for k, ball in enumerate(base.balls)
    ]
    yield "must not overlap", base.model_copy(update={"balls": tuple(heap)})


@dataclass(frozen=True)
class Unchecked(Trial):
    """A scene gets past its checks: it is refused before any kernel, and what is wrong is named.

    Attributes
    ----------
    name : str
    physics : str
        A key of `UNCHECKED`.
    balls : int
    value : float
        What numbers are replaced by.
    """

    name: str
    physics: str
    balls: int
    value: float
    small: ClassVar[bool] = False  # nothing gets as far as a kernel

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Try it."""
        base = unchecked_base(UNCHECKED[self.physics], self.balls)
        faults: list[str] = []
        tried = 0
        for says, scene in spoilt(base, self.value):
            tried += 1
            try:
                result = engine.simulate(scene, record="trajectory")
            except SceneError as error:
                if says not in str(error) or "made without its checks" not in str(error):
                    faults.append(f"the refusal should say {says!r}: {error}")
            else:
                faults.append(f"not refused: {says!r}; {result.status.name}, {result.reason!r}")
        return Verdict(tuple(faults), None, float(bool(faults)), tried, len(faults))

    def examples(self) -> Iterator[Scene]:
        """Yield the scene in order."""
        yield unchecked_base(UNCHECKED[self.physics], self.balls)


@dataclass(frozen=True)
class Overflow(Trial):
    """Speeds, times and places so large that products of them may overflow: finite, or FAILED.

    Attributes
    ----------
    name : str
    physics : str
    """

    name: str
    physics: str
    small: ClassVar[bool] = False  # interpreted, a division by zero raises

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Try it."""
        faults: list[str] = []
        tried = 0
        for scene in self.examples():
            tried += 1
            with blamed_on_engine(engine.name):  # what it hands back is what is judged here
                result = engine.simulate(scene, record="events")
            finite = all(bool(np.all(np.isfinite(part))) for part in result.final_state)
            if result.status is Status.FAILED and result.reason:
                continue
            if not finite or not math.isfinite(result.rest_time):
                faults.append(f"{scene.balls[0].velocity}: {result.status.name}, but not finite")
        return Verdict(tuple(faults), None, float(bool(faults)), tried, len(faults))

    def examples(self) -> Iterator[Scene]:
        """Yield the scenes."""
        base = unchecked_base(UNCHECKED[self.physics], 3)
        for speed in (1e10, 1e30, 1e50):
            for t_max in (1e-40, 1.0, 1e50):
                cue = base.balls[0].model_copy(update={"velocity": (speed, 0.1 * speed, 0.0)})
                balls = (cue, *base.balls[1:])
                yield Scene(
                    name="fast",
                    physics=base.physics,
                    t_max=t_max,
                    balls=balls,
                    table=None,
                )


SHOTS = ("rolling", "sliding")
"""Keys of `UNCHECKED`: physics whose interpreted kernels play the shot at once."""

COLUMNS = ("X", "VX", "VY", "WZ")
"""Numbers of a ball in motion that kernels read at every event; see `engine.core.state`.

None of them divides anything, which raises in interpreted kernels.
"""


@dataclass(frozen=True)
class Planted(Trial):
    """A NaN comes up in the midst of a run: it ends there, and says which ball, and when.

    The shot is laid out for the kernels, runs up to its first event, and gets the NaN there, as if
    the event had made it.

    Attributes
    ----------
    name : str
    physics : str
        One of `SHOTS`.
    column : str
        One of `COLUMNS`.
    """

    name: str
    physics: str
    column: str

    def run(self, engine: ReferenceEngine) -> Verdict:  # noqa: ARG002 - within our engine
        """Try it."""
        ball = 0
        run = Run(unchecked_base(UNCHECKED[self.physics], 3), True)
        run._enter(1, False)
        before = float(run._clock[state.NOW])
        run._state[ball, getattr(state, self.column)] = math.nan
        with np.errstate(all="ignore"):
            run.go(1_000)
        faults = check_named(run.status, run.reason, ball, before)
        return Verdict(tuple(faults), None, float(bool(faults)), 1, int(bool(faults)))

    def examples(self) -> Iterator[Scene]:
        """Yield the scene in order."""
        yield unchecked_base(UNCHECKED[self.physics], 3)


def check_named(status: Status, reason: str, ball: int, before: float) -> list[str]:
    """Return what is wrong with the end of a run in which a ball got a NaN.

    Parameters
    ----------
    status, reason : Status and str
        How it ended.
    ball : int
        Which got it.
    before : float [s]
        When.
    """
    if status is not Status.FAILED:
        return [f"a NaN in the motion of ball {ball} ends in {status.name}: {reason!r}"]
    said = re.match(r"`balls\[(\d+)\]`.* t = (\S+) s", reason, re.DOTALL)
    if said is None or int(said[1]) != ball or not before <= float(said[2]) < math.inf:
        return [
            f"the reason should name ball {ball} and an instant from {before!r} s on: {reason!r}"
        ]
    return []
