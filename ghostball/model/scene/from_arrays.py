"""Convert arrays of all balls to the fields of each ball, for a scene to check."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ghostball.model.arrays import FloatArray
from ghostball.model.scene.messages import refusal
from ghostball.model.scene.strike import Strike

_COMPONENTS = {"position": (2, 3), "velocity": (2, 3), "angular_velocity": (3,)}
_PLURALS = {"radius": "radii", "mass": "masses", "velocity": "velocities"} | {
    "position": "positions",
    "angular_velocity": "angular_velocities",
}


def fields_of_balls(
    ids: Sequence[str] | None, columns: Mapping[str, ArrayLike | None]
) -> list[dict[str, Any]]:
    """Return the fields of each ball from arrays for all balls; None omits a field.

    Only the shapes of the arrays are checked; the scene checks the values. Raises `SceneError` if
    the shapes don't match.
    """
    arrays = {name: _array(name, values) for name, values in columns.items() if values is not None}
    n = len(arrays["position"])
    names = [f"ball-{i}" for i in range(n)] if ids is None else list(ids)
    counts = {_PLURALS[name]: len(array) for name, array in arrays.items() if array.ndim > 0}
    for name, count in {**counts, "ids": len(names)}.items():
        if count != n:
            raise refusal(f"`{name}` must have {n} entries, one per ball, got {count}")
    lists: dict[str, list[Any]] = {"id": names}
    for name, values in arrays.items():
        vector = name in _COMPONENTS
        lists[name] = values.tolist() if vector else np.broadcast_to(values, n).tolist()
    keys = tuple(lists)
    return [dict(zip(keys, row)) for row in zip(*lists.values())]  # noqa: B905 - n of each


def add_strikes(balls: list[dict[str, Any]], strikes: Mapping[int, Strike]) -> None:
    """Add strikes, by index of the ball, to the fields of balls from `fields_of_balls`.

    Raises `SceneError` if there is no ball with an index.
    """
    for i, strike in strikes.items():
        if type(i) is not int or not 0 <= i < len(balls):
            raise refusal(
                f"`strikes` must name balls by index, 0 to {len(balls) - 1}, got {i!r}. Give "
                "{index: Strike(...)}"
            )
        balls[i]["strike"] = strike


def _array(name: str, values: ArrayLike) -> FloatArray:
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise refusal(f"`{_PLURALS[name]}` must be an array of numbers") from None
    components = _COMPONENTS.get(name)
    if components is None:
        if array.ndim > 1:
            raise refusal(
                f"`{_PLURALS[name]}` must be one number, or one for each ball, got an array of "
                f"shape {array.shape}"
            )
    elif array.ndim != 2 or array.shape[1] not in components:
        number = " or ".join(map(str, components))
        raise refusal(
            f"`{_PLURALS[name]}` must have the shape (balls, {number}), got {array.shape}"
        )
    return array
