"""Fit the cushion coefficients of engines to measured rebounds, and measure the remaining error."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray
from rich.console import RenderableType
from scipy.optimize import minimize

from benchmarks.commands import benchmark, with_progress
from benchmarks.measurements import BenchmarkMeasurement, table_of
from ghostball.model import Physics
from ghostball.model.features import Feature, has_feature
from ghostball.reference_adapters import ReferenceEngine, make_engine
from ghostball.validation.measured.best_settings import carom_cloth
from ghostball.validation.measured.rebounds import rebounds as measured_rebounds
from ghostball.validation.measured.table_agreement import ANGLES
from ghostball.validation.results.measurement import Record

ENGINE_LAWS: Final[Mapping[str, tuple[str, ...]]] = {
    "ghostball": ("han2005", "mathavan2010", "frictional", "restitution"),
    "pymunk": ("frictional",),
    "box2d": ("frictional",),
    "pybullet": ("frictional",),
    "mujoco": ("frictional",),
}
"""Cushion laws to fit, by engine: laws with friction, and one frictionless law for `ghostball`."""

_LOSS = "cushion_restitution_loss"
_SYMBOLS = {"cushion_restitution": "e", _LOSS: "c", "cushion_friction": "mu"}
_INITIAL_VALUES = ({"mu": 0.2, "e": 0.9, "c": 0.1}, {"mu": 0.3, "e": 0.9, "c": 0.1})
"""Initial values of the searches: one for sticking and one for slipping contacts."""


class BestRebounds(Record):
    """The best coefficients of one engine with one cushion law, and the remaining differences.

    `falls`: whether the restitution may fall with speed.
    `errors_off`: for each of `ANGLES`, the difference for each measured value, in standard errors.
    """

    engine: str
    law: str
    falls: bool
    coefficients: dict[str, float]
    errors_off: list[list[float]]

    @property
    def typical(self) -> float:
        """Root mean square of the differences, in standard errors."""
        return float(np.sqrt(np.mean(np.square(self.errors_off))))

    @property
    def row(self) -> tuple[str, str, str, str, str]:
        """Cells of the table: engine, law, coefficients, typical and largest difference."""
        values = ", ".join(f"{_SYMBOLS[name]} = {x:.3f}" for name, x in self.coefficients.items())
        most = float(np.max(np.abs(self.errors_off)))
        law = f"{self.law}, falls" if self.falls else self.law
        return self.engine, law, values, f"{self.typical:.1f}", f"{most:.1f}"


class ReboundsMeasurement(BenchmarkMeasurement):
    """Measurement of `python -m benchmarks rebounds`."""

    kind: Literal["rebounds"] = "rebounds"
    best: list[BestRebounds]

    @property
    def table(self) -> RenderableType:
        """Table with a row for each engine and law."""
        heads = ("engine", "law", "coefficients", "standard errors: typical", "largest")
        return table_of(heads, [one.row for one in self.best])


@benchmark
def rebounds() -> ReboundsMeasurement:
    """Fit each engine's cushions to rebounds measured on a real table."""
    cases = [
        (engine, law, falls)
        for engine in map(make_engine, ENGINE_LAWS)
        for law in ENGINE_LAWS[engine.name]
        for falls in (True, False)
        if not falls or has_feature(engine.capabilities, Feature.FALLING_RESTITUTION)
    ]
    found = with_progress(cases, lambda case: f"{case[0].name}, {case[1]}")
    return ReboundsMeasurement(
        best=[best_rebounds(engine, law, falls=falls) for engine, law, falls in found]
    )


def best_rebounds(engine: ReferenceEngine, law: str, *, falls: bool) -> BestRebounds:
    """Return the coefficients with which a cushion law fits the measurements best."""
    names = ["cushion_restitution"]
    names += [_LOSS] if falls else []
    names += ["cushion_friction"] if law != "restitution" else []
    cloth = carom_cloth(engine.capabilities)
    play = partial(engine.simulate, record="trajectory")

    def off(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
        found = dict(zip(names, map(float, numbers), strict=True))
        physics = Physics.model_validate(
            {"preset": "carom", "cushion": law, **cloth, _LOSS: 0.0, **found}
        )
        return np.array(
            [
                [one.errors_off for one in measured_rebounds(play, physics, angle)]
                for angle in ANGLES
            ]
        )

    # A method without derivatives: time steps make the result rough, and the result has a kink
    # where a contact starts to slip. Least squares stopped too early because of both.
    search = partial(
        minimize,
        lambda numbers: np.sum(np.square(off(numbers))),
        method="Nelder-Mead",
        bounds=[(0.0, 1.0)] * len(names),
        options={"maxfev": 100, "xatol": 1e-3, "fatol": 0.1},
    )
    ends = [search([start[_SYMBOLS[name]] for name in names]) for start in _INITIAL_VALUES]
    best = min(ends, key=lambda end: float(end.fun))
    numbers = [float(f"{number:.4g}") for number in best.x]
    return BestRebounds(
        engine=engine.name,
        law=law,
        falls=falls,
        coefficients=dict(zip(names, numbers, strict=True)),
        errors_off=[[float(f"{x:.3g}") for x in row] for row in off(np.array(numbers)).tolist()],
    )
