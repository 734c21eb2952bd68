"""How near an engine can come to measured rebounds: its best coefficients, and what is left."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray
from rich.console import RenderableType
from scipy.optimize import minimize

from benchmarks.measurements import Measurement, Record, table_of
from ghostball.model import Physics
from ghostball.reference_adapters import make_engine
from ghostball.validation.measured.rebounds import Play, rebounds
from ghostball.validation.parallel.pool import Progress

ANGLES: Final = (5.0, 45.0)
"""Angles from the normal of the balls that come to the cushion [degrees]."""

START: Final[Mapping[str, float]] = {
    "cushion_restitution": 0.9,
    "cushion_restitution_loss": 0.1,
    "cushion_friction": 0.25,
}
"""Where the search begins; the coefficients of cushions that are searched."""

_LOSS = "cushion_restitution_loss"
_PLAYERS: Final = (
    ("ghostball", "han2005", True),
    ("ghostball", "mathavan2010", True),
    ("ghostball", "frictional", True),
    ("ghostball", "han2005", False),
    ("ghostball", "mathavan2010", False),
    ("ghostball", "frictional", False),
    ("ghostball", "restitution", False),
    ("pymunk", "frictional", False),
    ("pybullet", "frictional", False),
    ("box2d", "frictional", False),
    ("mujoco", "frictional", False),
)
"""Engine, law of cushions, and whether its restitution may fall with speed."""


class BestRebounds(Record):
    """One engine with one law: its best coefficients, and how far off they leave it."""

    engine: str
    law: str
    falls: bool
    coefficients: dict[str, float]
    errors_off: list[list[float]]  # for each of `ANGLES`, for each bin of the facts

    @property
    def typical(self) -> float:
        """The root of the mean square of how many standard errors it is off."""
        return float(np.sqrt(np.mean(np.square(self.errors_off))))


class ReboundsMeasurement(Measurement):
    """What `python -m benchmarks rebounds` measured."""

    kind: Literal["rebounds"] = "rebounds"
    best: list[BestRebounds]

    @property
    def table(self) -> RenderableType:
        """It as one row for each engine and law."""
        heads = ("engine", "law", "coefficients", "standard errors off: typical", "most")
        return table_of(heads, [row_of(one) for one in self.best])


def row_of(one: BestRebounds) -> tuple[str, str, str, str, str]:
    """Return the cells of a row: engine, law, coefficients, typical, most."""
    names = {"cushion_restitution": "e", _LOSS: "c", "cushion_friction": "mu"}
    values = ", ".join(f"{names[name]} = {value:.3f}" for name, value in one.coefficients.items())
    law = f"{one.law}, falls" if one.falls else one.law
    most = float(np.max(np.abs(one.errors_off)))
    return one.engine, law, values, f"{one.typical:.1f}", f"{most:.1f}"


def measure_rebounds(*, progress: Progress[str] | None = None) -> ReboundsMeasurement:
    """Search the best coefficients of each engine and law."""
    best = []
    for done, (spec, law, falls) in enumerate(_PLAYERS, start=1):
        play = partial(make_engine(spec).simulate, record="trajectory")
        best.append(best_rebounds(spec, play, law, falls=falls))
        if progress is not None:
            progress(done, len(_PLAYERS), f"{spec}, {law}")
    return ReboundsMeasurement(best=best)


def best_rebounds(engine: str, play: Play, law: str, *, falls: bool) -> BestRebounds:
    """Return the coefficients with which a law comes nearest to what was measured.

    Rolling friction is the same number at any speed unless the restitution falls: what has the one
    has the other, of the engines here.
    """
    names = [name for name in START if falls or name != _LOSS]
    if law == "restitution":
        names.remove("cushion_friction")
    fixed: dict[str, Any] = {"preset": "carom", "cushion": law, _LOSS: 0.0}
    fixed |= {} if falls else {"rolling_friction_quadratic": 0.0, "rolling_friction": 0.0047}

    def off(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
        given = dict(zip(names, map(float, numbers), strict=True))
        physics = Physics(**(fixed | given))
        return np.array(
            [[one.errors_off for one in rebounds(play, physics, angle)] for angle in ANGLES]
        )

    # A simplex: where the contact begins to slip, and by an engine's steps, it has kinks at which
    # least squares with differences end too early.
    search = partial(
        minimize,
        lambda numbers: np.sum(np.square(off(numbers))),
        method="Nelder-Mead",
        bounds=[(0.0, 1.0)] * len(names),
        options={"maxfev": 100, "xatol": 1e-3, "fatol": 0.1},
    )
    found = search([START[name] for name in names])
    if (
        falls
    ):  # one of three numbers may lie flat at a bound, and is begun anew from other frictions
        others = ([*found.x[:2], friction] for friction in (0.2, 0.3))
        found = min((found, *map(search, others)), key=lambda one: float(one.fun))
    numbers = [float(f"{number:.4g}") for number in found.x]
    return BestRebounds(
        engine=engine,
        law=law,
        falls=falls,
        coefficients=dict(zip(names, numbers, strict=True)),
        errors_off=[[float(f"{x:.3g}") for x in row] for row in off(np.array(numbers)).tolist()],
    )
