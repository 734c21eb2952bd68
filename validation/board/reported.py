"""Faults that people reported of physics engines, as scenes: whoever has one finds it here.

Each file of `threads/` cites a thread, says what was reported, what causes it and what cures it,
and has a scene in which the fault shows, with the quantity of its end by which it is seen.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from importlib.resources import files
from typing import Annotated, Final, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from ghostball.engine import Result, Scene

Quantity = Literal["energy", "velocity", "spin", "position"]


class Reported(BaseModel):
    """One thread.

    Attributes
    ----------
    title, thread, said, cause, cure : str
        In a few words; its address; what was reported; what causes it; which setting cures it.
    quantity : str
        What of the end tells the fault, over what is right: see `off`.
    right, fair : float
        Up to which difference an engine is right, and right to what its step lets one expect.
    scene : Scene
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    title: str
    thread: Annotated[str, Field(pattern=r"^https://github\.com/[\w.-]+/[\w.-]+/issues/\d+$")]
    said: str
    cause: str
    cure: str
    quantity: Quantity
    right: Annotated[float, Field(gt=0.0)]
    fair: Annotated[float, Field(gt=0.0)]
    scene: Scene

    def off(self, found: Result, right: Result) -> float:
        """Return how far the end of a shot is off in the quantity, over what it is measured in."""
        return _OFF[self.quantity](found, right)


def _speed(result: Result) -> float:
    return float(np.max(np.linalg.norm(result.scene.velocities, axis=1)))


def _kinetic(result: Result) -> float:
    return float(result.scene.masses @ np.sum(result.final_state.velocities[0] ** 2, axis=1))


def _energy(found: Result, right: Result) -> float:
    return abs(_kinetic(found) / _kinetic(right) - 1.0)


def _velocity(found: Result, right: Result) -> float:
    change = found.final_state.velocities[0] - right.final_state.velocities[0]
    return float(np.max(np.linalg.norm(change, axis=1))) / _speed(right)


def _spin(found: Result, right: Result) -> float:
    change = found.final_state.angular_velocities[0] - right.final_state.angular_velocities[0]
    surface = right.scene.radii * np.linalg.norm(change, axis=1)
    return float(np.max(surface)) / _speed(right)


def _position(found: Result, right: Result) -> float:
    change = found.rest_positions - right.rest_positions
    return float(np.max(np.linalg.norm(change, axis=1)))


_OFF: Final[Mapping[Quantity, Callable[[Result, Result], float]]] = {
    "energy": _energy,
    "velocity": _velocity,
    "spin": _spin,
    "position": _position,
}


def _load() -> dict[str, Reported]:
    folder = files("ghostball.validation.board").joinpath("threads")
    found = {}
    for path in sorted(folder.iterdir(), key=lambda one: one.name):
        values = tomllib.loads(path.read_text(encoding="utf-8"))
        found[path.name.removesuffix(".toml")] = Reported.model_validate(values)
    return found


REPORTED: Final[Mapping[str, Reported]] = _load()
"""All of them, by the name of their file: the repository and the number of the thread."""
