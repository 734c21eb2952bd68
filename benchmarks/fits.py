"""A test of the errors that a fit states: fits of simulated tables whose physics are known.

The engine simulates half of the tables; a program that shares no code with it, the other half.
"""

from __future__ import annotations

import time
from functools import partial
from itertools import product
from typing import Any, Final, Literal

import numpy as np
from rich.console import Group, RenderableType

from benchmarks.frame import Count, benchmark, in_processes
from benchmarks.measurements import Shown, table_of
from benchmarks.stepped_tracks import Camera, SteppedTable, stepped_tracks
from benchmarks.synthetic_tracks import POOL, synthetic_tracks
from ghostball.cli.options import AUTO, Jobs
from ghostball.model import Physics
from ghostball.reference_adapters import make_engine
from ghostball.validation.measured.fit.clean_events import find_clean_events
from ghostball.validation.measured.fit.fit import NORMAL_95, fit_table
from ghostball.validation.results.measurement import Record

TABLES: Final = 200
"""Tables of a whole measurement."""
SHOTS: Final = 100
"""Shots of a table, and twice as many where the law of cushions is sought as well."""
FREE: Final = 8
"""Tables whose law is sought as well."""

_RANGES: Final = {
    "rolling_friction": (0.004, 0.012),
    "rolling_friction_quadratic": (0.0, 0.02),
    "sliding_friction": (0.13, 0.25),
    "ball_restitution": (0.90, 0.97),
    "cushion_restitution": (0.75, 0.95),
    "cushion_restitution_loss": (0.0, 0.15),
    "cushion_friction": (0.10, 0.30),
}
"""What tables have, evenly."""
_LAWS: Final = ("han2005", "mathavan2010", "frictional")


PROGRAMS: Final = {"engine": "by the engine", "steps": "by another program"}
"""Descriptions of the programs that simulate the shots."""


class FittedTable(Record):
    """One table: what it was, and what a fit said of it."""

    seed: int
    program: Literal["engine", "steps"]
    """What played the shots: our engine, or `stepped_tracks`."""
    law: str
    laws_alike: list[str]
    """Those that the tracks don't tell from the best, where a fit was asked for the law, too."""
    rate: float  # of the camera [1/s]
    noise: float  # of the tracker [m]
    side: float
    events: dict[str, int]
    goodness: float
    seconds: float  # of a fit that sought the law, alone or beside others; 0: there was none
    errors_off: dict[str, float]
    """By how many of its standard errors each value is above the true one, the law being known."""


class FitsMeasurement(Shown):
    """What `python -m benchmarks fits` measured."""

    kind: Literal["fits"] = "fits"
    tables: list[FittedTable]

    @property
    def rows(self) -> list[tuple[str, str, str, str]]:
        """For each field: in how many tables it was told, how often its errors held, the most."""
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
        """How many tables were fitted, and how many a whole measurement has."""
        return f"{len(self.tables)} tables were fitted; a whole measurement has {TABLES}."

    @property
    def sought(self) -> str:
        """What became of the laws of cushions that were sought, and how long it took."""
        free = [one for one in self.tables if one.laws_alike]
        if not free:
            return "The cushion law was given."
        told = sum(one.laws_alike == [one.law] for one in free)
        kept = sum(one.law in one.laws_alike for one in free)
        longest = max((one.seconds for one in free), default=0.0)
        return (
            f"The cushion law was given. In {len(free)} more fits it was fitted, too: {told} found "
            f"only the true law; {kept - told} found several laws that can't be distinguished, the "
            f"true law among them. A fit of {2 * SHOTS} shots without a given law took at most "
            f"{longest:.0f} s, while another fit ran."
        )

    @property
    def table(self) -> RenderableType:
        """It as a row for each field, its extent, and what became of the laws that were sought."""
        heads = ("field", "tables", f"within {NORMAL_95} standard errors", "most")
        return Group(table_of(heads, self.rows), self.extent, self.sought)


@benchmark
def fits(tables: Count = TABLES, jobs: Jobs = AUTO) -> FitsMeasurement:
    """Fit synthetic tables of known physics, and count how often the stated errors hold."""
    found = in_processes(range(tables), jobs, fitted_table, "table")
    return FitsMeasurement(tables=sorted(found, key=lambda one: one.seed))


def fitted_table(seed: int) -> FittedTable:
    """Return what a fit says of a table of random physics, tracker and camera."""
    random = np.random.default_rng([seed, 1])
    law = _LAWS[int(random.integers(len(_LAWS)))]
    true: dict[str, Any] = {name: float(random.uniform(*ends)) for name, ends in _RANGES.items()}
    rate, noise = float(random.choice([25.0, 50.0])), float(random.uniform(4e-4, 2e-3))
    side = float(random.choice([0.0, 0.3]))
    shots = 2 * SHOTS if seed < FREE else SHOTS
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
    laws_alike = fit().laws_alike if seed < FREE else []
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
