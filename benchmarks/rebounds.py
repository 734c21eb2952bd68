"""How near an engine can come to measured rebounds: its best coefficients, and what is left."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray
from rich.console import RenderableType
from scipy.optimize import minimize

from benchmarks.frame import benchmark, counted
from benchmarks.measurements import Shown, table_of
from ghostball.model import Physics
from ghostball.model.features import Feature, has_feature
from ghostball.reference_adapters import ReferenceEngine, make_engine
from ghostball.validation.measured.facts import facts_of
from ghostball.validation.measured.rebounds import rebounds as measured_rebounds
from ghostball.validation.measured.table_agreement import ANGLES
from ghostball.validation.results.measurement import Record

PLAYERS: Final[Mapping[str, tuple[str, ...]]] = {
    "ghostball": ("han2005", "mathavan2010", "frictional", "restitution"),
    "pymunk": ("frictional",),
    "box2d": ("frictional",),
    "pybullet": ("frictional",),
    "mujoco": ("frictional",),
}
"""Engines, with the laws of cushions that they have and that turn balls; ours, one that doesn't."""

_LOSS = "cushion_restitution_loss"
_SYMBOLS = {"cushion_restitution": "e", _LOSS: "c", "cushion_friction": "mu"}
_STARTS = ({"mu": 0.2, "e": 0.9, "c": 0.1}, {"mu": 0.3, "e": 0.9, "c": 0.1})
"""Where each search begins: on both sides of where a contact begins to slip."""


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

    @property
    def row(self) -> tuple[str, str, str, str, str]:
        """The cells of its row: engine, law, coefficients, typical, most."""
        values = ", ".join(f"{_SYMBOLS[name]} = {x:.3f}" for name, x in self.coefficients.items())
        most = float(np.max(np.abs(self.errors_off)))
        law = f"{self.law}, falls" if self.falls else self.law
        return self.engine, law, values, f"{self.typical:.1f}", f"{most:.1f}"


class ReboundsMeasurement(Shown):
    """What `python -m benchmarks rebounds` measured."""

    kind: Literal["rebounds"] = "rebounds"
    best: list[BestRebounds]

    @property
    def table(self) -> RenderableType:
        """It as one row for each engine and law."""
        heads = ("engine", "law", "coefficients", "standard errors off: typical", "most")
        return table_of(heads, [one.row for one in self.best])


@benchmark
def rebounds() -> ReboundsMeasurement:
    """Search how near each engine can come to rebounds measured on a real table."""
    cases = [
        (engine, law, falls)
        for engine in map(make_engine, PLAYERS)
        for law in PLAYERS[engine.name]
        for falls in (True, False)
        if not falls or has_feature(engine.capabilities, Feature.FALLING_RESTITUTION)
    ]
    found = counted(cases, lambda case: f"{case[0].name}, {case[1]}")
    return ReboundsMeasurement(
        best=[best_rebounds(engine, law, falls=falls) for engine, law, falls in found]
    )


def best_rebounds(engine: ReferenceEngine, law: str, *, falls: bool) -> BestRebounds:
    """Return the coefficients with which a law comes nearest to what was measured.

    The cloth is that of the preset `carom`; of an engine whose rolling friction is one number at
    any speed, that number is what was measured in the middle of the speeds.
    """
    names = ["cushion_restitution"]
    names += [_LOSS] if falls else []
    names += ["cushion_friction"] if law != "restitution" else []
    cloth: dict[str, Any] = {}
    if not has_feature(engine.capabilities, Feature.QUADRATIC_ROLLING):
        middle = facts_of("rolling-carom").rows[1].value
        cloth = {"rolling_friction": middle / 9.81, "rolling_friction_quadratic": 0.0}
    play = partial(engine.simulate, record="trajectory")

    def off(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
        found = dict(zip(names, map(float, numbers), strict=True))
        physics = Physics(preset="carom", cushion=law, **{**cloth, _LOSS: 0.0, **found})
        return np.array(
            [
                [one.errors_off for one in measured_rebounds(play, physics, angle)]
                for angle in ANGLES
            ]
        )

    # Without derivatives: steps make an engine rough, and it has kinks where a contact begins to
    # slip; at both least squares ended too early.
    search = partial(
        minimize,
        lambda numbers: np.sum(np.square(off(numbers))),
        method="Nelder-Mead",
        bounds=[(0.0, 1.0)] * len(names),
        options={"maxfev": 100, "xatol": 1e-3, "fatol": 0.1},
    )
    ends = [search([start[_SYMBOLS[name]] for name in names]) for start in _STARTS]
    best = min(ends, key=lambda end: float(end.fun))
    numbers = [float(f"{number:.4g}") for number in best.x]
    return BestRebounds(
        engine=engine.name,
        law=law,
        falls=falls,
        coefficients=dict(zip(names, numbers, strict=True)),
        errors_off=[[float(f"{x:.3g}") for x in row] for row in off(np.array(numbers)).tolist()],
    )
