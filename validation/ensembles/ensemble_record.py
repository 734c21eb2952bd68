"""What is known of an ensemble: what was asked for, what became of its members."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict

from ghostball.engine import Scene
from ghostball.engine.scene.fields import SceneName
from ghostball.validation.ensembles.members import Size, Stream
from ghostball.validation.results.fields import Definition, EnvironmentValues, FloatArray
from ghostball.validation.results.record_store import RunState
from ghostball.validation.results.records import scene_from

REFERENCE: Final = "ghostball"
"""The engine that the others are compared with: the one that has every scene's own model."""

INSTANTS: Final = 41
"""Instants at which the energy is kept, from the start to the end of the unperturbed scene."""

EnsembleOutcomeName = Literal["ran", "not-representable", "unavailable"]


@dataclass(frozen=True, eq=False)
class EnsembleRecord:
    """One ensemble: the members of one scene on one engine.

    Attributes
    ----------
    scene : str
    definition : dict
        The unperturbed scene as plain values; `load_scene` makes the `Scene` of it.
    label, engine : str
        The engine as asked for, such as "pymunk:mode=landed", and its name alone.
    stream : "shots" or "null"
        Members that every engine runs; or others, on which our engine is compared with itself.
    size : Size
    settings : dict
        All settings of the engine.
    times : (q,) float64 [s]
        When the energy is taken.
    energy_initial : float [J]
        Of the unperturbed scene.
    outcome : "ran", "not-representable" or "unavailable"
    reason : str
        Why it did not run; else "".
    stopped, failed : dict of str to str
        By number of the member: how it ended early, why it failed.
    inputs : str
        Hash of all that is asked of its members.
    """

    scene: SceneName
    definition: Definition
    label: str
    engine: str
    stream: Stream
    size: Size
    settings: dict[str, Any] = field(default_factory=dict)
    times: FloatArray = field(default_factory=lambda: np.zeros(0))
    energy_initial: float = 0.0
    outcome: EnsembleOutcomeName = "ran"
    reason: str = ""
    stopped: dict[str, str] = field(default_factory=dict)
    failed: dict[str, str] = field(default_factory=dict)
    inputs: str = ""

    __pydantic_config__ = ConfigDict(extra="forbid", arbitrary_types_allowed=True)

    @property
    def key(self) -> tuple[str, str, Stream]:
        """Scene, engine label and stream: what tells ensembles apart."""
        return self.scene, self.label, self.stream

    def load_scene(self) -> Scene:
        """Return the unperturbed scene."""
        return scene_from(self.definition, self.scene)


@dataclass(frozen=True)
class EnsembleRun:
    """What a run was asked for, and how it ended.

    Attributes
    ----------
    count : int
        Members of each ensemble.
    size : Size
    scenes, labels : tuple of str
    state : "running", "complete" or "interrupted"
    environment : dict
        Date, machine, versions, revision, command line.
    run : str
        What tells it from any other run.
    ensembles : tuple of EnsembleRecord
        What is asked of each, before any member was run.
    """

    count: int
    size: Size
    scenes: tuple[SceneName, ...]
    labels: tuple[str, ...]
    environment: EnvironmentValues
    state: RunState = "running"
    run: str = ""
    ensembles: tuple[EnsembleRecord, ...] = ()

    __pydantic_config__ = ConfigDict(extra="forbid")


@dataclass(frozen=True, eq=False)
class Members:
    """What the members of one ensemble that came to their end did, in order of their numbers.

    Attributes
    ----------
    index : (m,) int64
        Number of each, from 0.
    rest_positions : (m, n, 2) float64 [m]
        Centres on the cloth when the run ended.
    rest_times : (m,) float64 [s]
    counts : (m, 2) int64
        Ball-ball and ball-cushion collisions.
    energy : (m, q) float64 [J]
        At the instants of `EnsembleRecord.times`.
    """

    index: NDArray[np.int64]
    rest_positions: NDArray[np.float64]
    rest_times: NDArray[np.float64]
    counts: NDArray[np.int64]
    energy: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.index)

    @classmethod
    def none(cls, balls: int) -> Members:
        """Return no members of a scene of so many balls."""
        return cls(
            np.zeros(0, dtype=np.int64),
            np.zeros((0, balls, 2)),
            np.zeros(0),
            np.zeros((0, 2), dtype=np.int64),
            np.zeros((0, INSTANTS)),
        )

    def parts(self) -> tuple[NDArray[Any], ...]:
        """Return the arrays, in order of the attributes."""
        return self.index, self.rest_positions, self.rest_times, self.counts, self.energy
