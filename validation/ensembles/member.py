"""One member on one engine: run, looked at, and reduced to what is compared."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict

from ghostball.engine import EngineFailedError, Scene, UnsupportedSceneError
from ghostball.engine.result import COLLISION_KINDS
from ghostball.reference_adapters.registry import EngineUnavailableError, make_engine
from ghostball.validation.ensembles.members import Stream
from ghostball.validation.results.fields import FloatArray
from ghostball.validation.results.records import status_name
from ghostball.validation.runs.playing import run_engine
from ghostball.validation.runs.sampling import energy_at

MemberOutcome = Literal["ended", "stopped", "failed", "not-representable", "unavailable"]


@dataclass(frozen=True, eq=False)
class MemberTask:
    """What to run.

    Attributes
    ----------
    scene : Scene
        The member, perturbed.
    label : str
        The engine with its settings.
    stream : "shots" or "null"
    index : int
    times : (q,) float64 [s]
        When to take the energy.
    inputs : str
        Hash of what is asked of its ensemble.
    """

    scene: Scene
    label: str
    stream: Stream
    index: int
    times: NDArray[np.float64]
    inputs: str = ""


@dataclass(frozen=True, eq=False)
class MemberResult:
    """What became of a member.

    Attributes
    ----------
    scene, label, stream, index, inputs
        Of the task.
    outcome : str
        "ended" came to rest or to the scene's `t_max`; "stopped" didn't, though nothing failed.
    reason : str
        Why it didn't end; else "".
    rest_positions : (n, 2) float64 [m]
    rest_time : float [s]
    counts : tuple of int
        By kind, in the order of `COLLISION_KINDS`.
    energy : (q,) float64 [J]
        Like the three above, None where it didn't end.
    """

    scene: str
    label: str
    stream: Stream
    index: int
    outcome: MemberOutcome
    reason: str = ""
    rest_positions: FloatArray | None = None
    rest_time: float | None = None
    counts: tuple[int, ...] | None = None
    energy: FloatArray | None = None
    inputs: str = ""

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    @property
    def ensemble(self) -> tuple[str, str, Stream]:
        """Scene, engine label and stream of its ensemble."""
        return self.scene, self.label, self.stream


def run_member(task: MemberTask) -> MemberResult:
    """Run a member; whatever goes wrong becomes part of what is returned.

    Raises
    ------
    KeyboardInterrupt
        Where the run was interrupted.
    """
    try:
        result = run_engine(make_engine(task.label), task.scene)
        if not result.status.complete:
            why = f": {result.reason}" if result.reason else ""
            return unended(task, f"{status_name(result.status)}{why}", "stopped")
        with np.errstate(invalid="ignore", over="ignore"):
            energy = energy_at(result, task.times).total
        if not np.all(np.isfinite(energy)):
            return unended(task, "the energy of its motion is not finite")
        return replace(
            unended(task, "", "ended"),
            rest_positions=np.array(result.rest_positions[:, :2], dtype=np.float64),
            rest_time=float(result.rest_time),
            counts=tuple(int(result.collision_counts[kind.label]) for kind in COLLISION_KINDS),
            energy=energy,
        )
    except EngineUnavailableError as error:
        return unended(task, str(error), "unavailable")
    except UnsupportedSceneError as error:
        return unended(task, "; ".join(error.features), "not-representable")
    except EngineFailedError as error:
        return unended(task, error.reason)
    # An engine may raise anything, and its `sys.exit` must not end the run: kept, never fatal.
    except (Exception, SystemExit) as error:
        return unended(task, f"{type(error).__name__}: {error}")


def unended(task: MemberTask, reason: str, outcome: MemberOutcome = "failed") -> MemberResult:
    """Return what became of a member that has no end, such as one whose process died of it."""
    where = (task.scene.name, task.label, task.stream, task.index)
    return MemberResult(*where, outcome, reason, inputs=task.inputs)
