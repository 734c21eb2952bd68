"""Strokes of a cue as arrays, with random errors, for many shots of one scene."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ghostball.model import Scene, SceneError, Strike
from ghostball.model.errors import GhostballError
from ghostball.model.scene.messages import refusal
from ghostball.model.scene.strike import Aims, are_valid

_MOST_DRAWS = 1_000
"""Largest number of draws of the noise of a stroke. A stroke at two limits at once, such as a level
cue at the miscue limit, takes four draws on average."""


@dataclass(frozen=True, eq=False)
class Strokes:
    """Strokes of a cue at one ball of a scene, one for each of k shots.

    Attributes
    ----------
    speed, direction, elevation, offset_left, offset_up : (k,) float64, or one number for all
        As in `Strike` [m/s, rad, rad, radii, radii].
    ball : int or str
        Index or id of the ball that is struck. The masses, the tip and the squirt of the cue are
        those of the ball's `strike` in the scene; without one, those of `Strike`.
    noise : dict of str to float
        Standard deviations of normal random errors, by name of the field, in its unit. If an error
        makes the stroke impossible, such as a miscue or a cue below the cloth, all errors of this
        stroke are drawn again: the distribution is normal within the limits of `Strike`.
    seed : int
        Seed of the noise. The errors of shot i depend on the seed and on i, not on the number of
        shots or threads.

    Raises
    ------
    GhostballError
        If an array has a wrong shape or isn't finite, or if `noise` or `seed` is invalid. The
        values are checked by `drawn`, because the limits depend on the cue.
    """

    speed: ArrayLike
    direction: ArrayLike
    elevation: ArrayLike = 0.0
    offset_left: ArrayLike = 0.0
    offset_up: ArrayLike = 0.0
    ball: int | str = 0
    noise: Mapping[str, float] = field(default_factory=dict)
    seed: int = 0

    def __post_init__(self) -> None:
        for name in Aims._fields:
            object.__setattr__(self, name, numbers_of(f"strokes.{name}", getattr(self, name)))
        self._aims(1)
        if not isinstance(self.noise, Mapping):
            raise GhostballError(
                f"`noise` must be a dict, got {type(self.noise).__name__}. Give "
                '{"direction": 0.002}, the standard deviation of each field'
            )
        for name, deviation in self.noise.items():
            if name not in Aims._fields:
                raise GhostballError(
                    f"`noise` must name fields of a stroke, {', '.join(Aims._fields)}, got {name!r}"
                )
            number = isinstance(deviation, int | float) and not isinstance(deviation, bool)
            if not number or not 0.0 <= deviation < math.inf:
                raise GhostballError(
                    f'`noise["{name}"]` must be a number of at least 0, got {deviation!r}'
                )
        if type(self.seed) is not int or self.seed < 0:
            raise GhostballError(f"`seed` must be a whole number of at least 0, got {self.seed!r}")

    def drawn(self, scene: Scene, k: int = 1) -> DrawnStrokes:
        """Return the strokes that are played in a scene: with noise, and checked.

        Parameters
        ----------
        scene : Scene
        k : int
            Number of shots, if the fields are single numbers.

        Raises
        ------
        SceneError
            If a stroke breaks a rule of `Strike`; the message names the shot.
        GhostballError
            If there is no such ball, if k doesn't fit the arrays, or if the noise is so large that
            nearly all strokes with it are impossible.
        """
        who = scene.index_of(self.ball, "strokes.ball")
        cue = scene.balls[who].strike or Strike(speed=1.0, direction=0.0)
        aims = self._aims(k)
        strokes = DrawnStrokes(who, cue, *aims, np.ones(len(aims.speed), dtype=np.int64))
        for i in np.flatnonzero(~are_valid(cue, aims))[:1]:
            try:
                strokes.strike(i)
            except SceneError as error:
                raise refusal(f"`strokes` of shot {i}: {error}") from None
        return self._with_noise(strokes) if any(self.noise.values()) else strokes

    def _with_noise(self, strokes: DrawnStrokes) -> DrawnStrokes:
        """Return valid strokes with errors added."""
        deviations = np.array([self.noise.get(name, 0.0) for name in Aims._fields])
        exact = np.stack(strokes.aims, axis=1)
        found, draws, pending = exact.copy(), strokes.draws, np.arange(len(exact))
        for again in range(_MOST_DRAWS):
            if len(pending) == 0:
                return DrawnStrokes(strokes.ball, strokes.cue, *Aims(*found.T.copy()), draws)
            # The errors of all shots before the last pending one are drawn, so that they don't
            # depend on the number of shots.
            shape = (int(pending[-1]) + 1, len(deviations))
            errors = np.random.default_rng([self.seed, again]).standard_normal(shape)[pending]
            tried = exact[pending] + deviations * errors
            turned = tried[:, 1]  # a direction beyond a whole turn is valid, too
            turned -= np.where(np.abs(turned) > 2.0 * np.pi, np.copysign(2.0 * np.pi, turned), 0.0)
            valid = are_valid(strokes.cue, Aims(*tried.T))
            found[pending[valid]], draws[pending] = tried[valid], again + 1
            pending = pending[~valid]
        raise GhostballError(
            f"`noise` must leave most strokes possible, but {_MOST_DRAWS} draws for shot "
            f"{pending[0]} gave none. Lower the noise, or move the stroke away from the limits of "
            "the cue"
        )

    def _aims(self, k: int) -> Aims:
        """Return the fields before noise, (k,) each."""
        arrays = {name: getattr(self, name) for name in Aims._fields}
        counts = {len(array) for array in arrays.values()} | {k}
        if len(counts - {1}) > 1:
            lengths = ", ".join(f"{len(array)} of `{name}`" for name, array in arrays.items())
            raise GhostballError(
                "the fields of `strokes` must have one number per shot, or one number for all "
                f"shots; got {lengths}" + (f", for {k} shots" if k != 1 else "")
            )
        k = (counts - {1} or {1}).pop()
        return Aims(*(np.array(np.broadcast_to(array, k)) for array in arrays.values()))


class DrawnStrokes(NamedTuple):
    """The strokes of k shots as they are played, with their noise."""

    ball: int
    """Index of the ball that is struck."""
    cue: Strike
    """The strike that has the masses, the tip and the squirt of the cue."""
    speed: NDArray[np.float64]
    direction: NDArray[np.float64]
    elevation: NDArray[np.float64]
    offset_left: NDArray[np.float64]
    offset_up: NDArray[np.float64]
    draws: NDArray[np.int64]
    """Number of draws of the noise, (k,): more than 1 if the first stroke was impossible."""

    @property
    def aims(self) -> Aims:
        """The fields that differ between the shots, (k,) each."""
        return Aims(*self[2:7])

    def strike(self, i: int) -> Strike:
        """Return the stroke of shot i."""
        own = {name: float(values[i]) for name, values in self.aims._asdict().items()}
        return Strike(**dict(self.cue) | own)


def numbers_of(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Return `values` as a checked array (k,); error messages call it `name`."""
    try:
        array = np.atleast_1d(np.array(values, dtype=np.float64))  # a copy
    except (TypeError, ValueError):
        raise GhostballError(f"`{name}` must be numbers, got {repr(values)[:80]}") from None
    if array.ndim != 1:
        raise GhostballError(f"`{name}` must be one-dimensional, got shape {array.shape}")
    for i in np.flatnonzero(~np.isfinite(array))[:1]:
        where = f" for shot {i}" if len(array) > 1 else ""
        raise GhostballError(f"`{name}` must be finite, got {array[i]}{where}")
    return array
