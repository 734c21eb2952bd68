"""Test the standard errors of fits: fit simulated tables with known physics.

Ghostball's engine simulates half of the tables, and an independent program the other half.
"""

from __future__ import annotations

import time
from functools import partial
from itertools import product
from typing import Any, Final, Literal

import numpy as np
from rich.console import Group, RenderableType

from benchmarks.commands import Count, benchmark, in_processes
from benchmarks.measurements import BenchmarkMeasurement, table_of
from benchmarks.stepped_tracks import Camera, SteppedTable, stepped_tracks
from benchmarks.synthetic_tracks import POOL, synthetic_tracks
from ghostball.cli.options import AUTO, Jobs
from ghostball.model import Physics
from ghostball.reference_adapters import make_engine
from ghostball.validation.measured.fit.clean_events import find_clean_events
from ghostball.validation.measured.fit.fit import NORMAL_95, fit_table
from ghostball.validation.results.measurement import Record

TABLES: Final = 200
"""Number of tables of a whole measurement."""
SHOTS: Final = 100
"""Number of shots on a table; twice as many if the fit also searches the cushion law."""
LAW_SEARCHES: Final = 8
"""Number of tables for which the fit also searches the cushion law."""

_RANGES: Final = {
    "rolling_friction": (0.004, 0.012),
    "rolling_friction_quadratic": (0.0, 0.02),
    "sliding_friction": (0.13, 0.25),
    "ball_restitution": (0.90, 0.97),
    "cushion_restitution": (0.75, 0.95),
    "cushion_restitution_loss": (0.0, 0.15),
    "cushion_friction": (0.10, 0.30),
}
"""Ranges of the uniformly distributed true values."""
_LAWS: Final = ("han2005", "mathavan2010", "frictional")

PROGRAMS: Final = {"engine": "by the engine", "steps": "by another program"}
"""Descriptions of the programs that simulate the shots."""


class FittedTable(Record):
    """One simulated table and its fit.

    `program`: what simulated the shots: Ghostball's engine, or `stepped_tracks`.
    `law`: the true cushion law.
    `laws_alike`: laws that the tracks don't distinguish from the best one, if the fit searched the
        law; else empty.
    `rate` [1/s]: pictures per second.
    `noise` [m]: standard deviation of a coordinate.
    `side`: standard deviation of the side spin, R w_z / v.
    `seconds` [s]: time of the fit that searched the law; 0 without such a fit. Other fits may have
        run at the same time.
    `errors_off`: by field, the fitted value minus the true one, in standard errors, for the fit
        with the true law.
    """

    seed: int
    program: Literal["engine", "steps"]
    law: str
    laws_alike: list[str]
    rate: float
    noise: float
    side: float
    events: dict[str, int]
    goodness: float
    seconds: float
    errors_off: dict[str, float]


class FitsMeasurement(BenchmarkMeasurement):
    """Measurement of `python -m benchmarks fits`."""

    kind: Literal["fits"] = "fits"
    tables: list[FittedTable]

    @property
    def rows(self) -> list[tuple[str, str, str, str]]:
        """Cells for each field and program: tables, part within the errors, largest deviation."""
        rows = []
        for name, program in product(_RANGES, PROGRAMS):
            alike = [one.errors_off for one in self.tables if one.program == program]
            off = np.abs([errors[name] for errors in alike if name in errors])
            if len(off):
                held = f"{100.0 * np.mean(off <= NORMAL_95):.1f} %"
                rows.append((name, f"{len(off)}, {PROGRAMS[program]}", held, f"{np.max(off):.1f}"))
        return rows

    @property
    def extent(self) -> str:
        """Sentence with the number of fitted tables, and the number in a whole measurement."""
        return f"{len(self.tables)} tables were fitted; a whole measurement has {TABLES}."

    @property
    def law_searches(self) -> str:
        """Sentences about the fits that searched the cushion law, and their time."""
        searched = [one for one in self.tables if one.laws_alike]
        if not searched:
            return "The cushion law was given."
        identified = sum(one.laws_alike == [one.law] for one in searched)
        kept = sum(one.law in one.laws_alike for one in searched)
        longest = max((one.seconds for one in searched), default=0.0)
        return (
            f"The cushion law was given. In {len(searched)} more fits, the law was fitted, too: "
            f"{identified} found only the true law; {kept - identified} found several laws that "
            "can't be distinguished, the true law among them. A fit of "
            f"{2 * SHOTS} shots without a given law took at most {longest:.0f} s, while another "
            "fit ran."
        )

    @property
    def table(self) -> RenderableType:
        """Table with a row for each field, and the sentences below it."""
        heads = ("field", "tables", f"within {NORMAL_95} standard errors", "largest")
        return Group(table_of(heads, self.rows), self.extent, self.law_searches)


@benchmark
def fits(tables: Count = TABLES, jobs: Jobs = AUTO) -> FitsMeasurement:
    """Fit simulated tables with known physics; count how often the standard errors hold."""
    found = in_processes(range(tables), jobs, fitted_table, "table")
    return FitsMeasurement(tables=sorted(found, key=lambda one: one.seed))


def fitted_table(seed: int) -> FittedTable:
    """Return the fit of a table with random physics, tracker and camera."""
    random = np.random.default_rng([seed, 1])
    law = _LAWS[int(random.integers(len(_LAWS)))]
    true: dict[str, Any] = {name: float(random.uniform(*ends)) for name, ends in _RANGES.items()}
    rate, noise = float(random.choice([25.0, 50.0])), float(random.uniform(4e-4, 2e-3))
    side = float(random.choice([0.0, 0.3]))
    shots = 2 * SHOTS if seed < LAW_SEARCHES else SHOTS
    program: Literal["engine", "steps"] = "steps" if seed % 2 else "engine"
    if program == "engine":
        physics = Physics(preset="pool", cushion=law, **true)
        tracks = synthetic_tracks(physics, shots, seed, rate=rate, noise=noise, side=side)
    else:
        law, side = "han2005", 0.25
        true |= {"rolling_friction_quadratic": 0.0, "cushion_restitution_loss": 0.0}
        own = ("rolling_friction", "sliding_friction", "ball_restitution")
        table = SteppedTable(
            **{name: true[name] for name in (*own, "cushion_restitution", "cushion_friction")},
            ball_friction=float(random.uniform(0.03, 0.09)),
            nose_height=2.0 * POOL.radius * float(random.uniform(0.625, 0.645)),
        )
        camera = Camera(rate=rate, noise=noise, drift=float(random.uniform(0.0, 0.7)))
        tracks = stepped_tracks(table, POOL, shots, seed, camera, side=side)
    engine = make_engine("ghostball")
    start = time.perf_counter()
    found = find_clean_events(tracks, POOL)
    fit = partial(fit_table, found, engine, partial(engine.simulate, record="trajectory"))
    laws_alike = fit().laws_alike if seed < LAW_SEARCHES else []
    seconds = time.perf_counter() - start
    fitted = fit(law=law)
    return FittedTable(
        seed=seed,
        program=program,
        law=law,
        laws_alike=laws_alike,
        rate=rate,
        noise=noise,
        side=side,
        events={name: len(events) for name, events in fitted.families.items()},
        goodness=round(fitted.goodness, 3),
        seconds=round(seconds, 1) if laws_alike else 0.0,
        errors_off={
            name: round((getattr(fitted.physics, name) - true[name]) / error, 3)
            for name, error in fitted.errors.items()
        },
    )
