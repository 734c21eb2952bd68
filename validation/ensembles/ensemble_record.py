"""What is known of an ensemble: what was asked for, what became of its members."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict

from engine import Scene
from validation.ensembles.members import Size, Stream
from validation.results.records import FloatArray, scene_from

SCHEMA: Final = 1
"""Version of `ensembles.jsonl` and of the arrays beside it; another one is refused."""

FORMAT: Final = "ghostball ensembles"

REFERENCE: Final = "ghostball"
"""The engine that the others are compared with: the one that has every scene's own model."""

INSTANTS: Final = 41
"""Instants at which the energy is kept, from the start to the end of the unperturbed scene."""

EnsembleOutcomeName = Literal["ran", "not-representable", "unavailable"]
EnsembleState = Literal["running", "complete", "interrupted"]


@dataclass(frozen=True)
class EnsembleRun:
    """What a run was asked for: the first line of `ensembles.jsonl`.

    Attributes
    ----------
    count : int
        Members of each ensemble.
    size : Size
    scenes, labels : tuple of str
    state : "running", "complete" or "interrupted"
    records : int
        Lines that follow.
    environment : dict
        Date, machine, versions, revision, command line.
    format, schema
    """

    count: int
    size: Size
    scenes: tuple[str, ...]
    labels: tuple[str, ...]
    environment: dict[str, Any]
    state: EnsembleState = "running"
    records: int = 0
    format: str = FORMAT
    schema: int = SCHEMA

    __pydantic_config__ = ConfigDict(extra="forbid")


@dataclass(frozen=True, eq=False)
class EnsembleRecord:
    """One ensemble: the members of one scene on one engine; a line of `ensembles.jsonl`.

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
    arrays : str or None
        File of what the members that came to their end did, relative to the folder; None without.
    arrays_hash : str
        SHA-256 of that file; "" where there is none.
    measured : str
        When its last member was run: date and time in UTC, ISO 8601.
    kept : bool
        Whether it is of an earlier run and no part of this one's results: kept for a later run that
        may find it unchanged.
    inputs_hash, code_hash : str
        Hashes of all that decides what its members do. "" where they must be run again.
    schema : int
    """

    scene: str
    definition: dict[str, Any]
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
    arrays: str | None = None
    arrays_hash: str = ""
    measured: str = ""
    kept: bool = False
    inputs_hash: str = ""
    code_hash: str = ""
    schema: int = SCHEMA

    __pydantic_config__ = ConfigDict(extra="forbid", arbitrary_types_allowed=True)

    @property
    def key(self) -> tuple[str, str, Stream]:
        """Scene, engine label and stream: what tells ensembles apart."""
        return self.scene, self.label, self.stream

    def load_scene(self) -> Scene:
        """Return the unperturbed scene."""
        return scene_from(self.definition, self.scene)


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

    def below(self, count: int) -> Members:
        """Return those whose number is below `count`."""
        those = self.index < count
        return Members(*(part[those] for part in self.parts()))

    def parts(self) -> tuple[NDArray[Any], ...]:
        """Return the arrays, in order of the attributes."""
        return self.index, self.rest_positions, self.rest_times, self.counts, self.energy
