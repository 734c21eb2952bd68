"""Share of breaks that pocket a ball, compared with 118 breaks of professionals.

This is a plausibility check, not a test: the published counts (Alciatore's site, "8-ball break
statistics") state neither the speeds of the cue balls nor the gaps of the racks. Both are assumed
here.
"""

from __future__ import annotations

import math
import random
from typing import Final, Literal

from rich.console import RenderableType

from benchmarks.commands import Count, benchmark, with_progress
from benchmarks.measurements import BenchmarkMeasurement, table_of
from benchmarks.scenes import racked
from ghostball.engine import simulate
from ghostball.model import POOL_BALL_RADIUS, EventKind, Scene, Table

BREAKS = 4_000
"""Number of breaks of a whole measurement; the standard error of a share of 80 % is 0.6 %."""

TABLE: Final = Table.model_validate("bar-7ft")

SPEEDS: Final = (7.0, 11.0)
"""Assumed range of the speed of the cue ball at a break [m/s]."""

LARGEST_GAP: Final = 0.5e-3
"""Assumed largest gap of a rack [m]."""

LARGEST_OFFSET: Final = 0.15
"""Assumed largest offset of the first hit from the centre, in radii."""

PUBLISHED: Final = {"made": (0.805, 118), "scratch": (0.076, 118)}
"""Published share of breaks that made a ball, and that pocketed the cue ball; number of breaks."""


class MadeBallsMeasurement(BenchmarkMeasurement):
    """Measurement of `python -m benchmarks made-balls`.

    `made`: number of breaks in which a ball other than the cue ball was pocketed.
    `scratched`: number of breaks in which the cue ball was pocketed.
    `pocketed`: number of pocketed balls.
    """

    kind: Literal["made-balls"] = "made-balls"
    breaks: int
    made: int
    scratched: int
    pocketed: int

    @property
    def table(self) -> RenderableType:
        """Table of the shares, with the published shares and their standard errors."""
        return table_of(("breaks", f"of {self.breaks} here", "published"), self.rows)

    @property
    def rows(self) -> list[tuple[str, str, str]]:
        """Cells for each outcome: name, share in this measurement, published share."""
        rows = []
        for name, count in (("made", self.made), ("scratch", self.scratched)):
            share, of = PUBLISHED[name]
            error = math.sqrt(share * (1.0 - share) / of)
            here, published = _percent(count / self.breaks), _percent(share)
            rows.append((name, here, f"{published} ± {_percent(error)}"))
        return rows


def _percent(share: float) -> str:
    return f"{100.0 * share:.1f} %"


def break_of(number: int) -> Scene:
    """Return an eight-ball break on a bar table; a number is always the same break."""
    chance = random.Random(f"made {number}")
    gap = chance.uniform(0.0, LARGEST_GAP)
    speed = chance.uniform(*SPEEDS)
    offset = chance.uniform(-LARGEST_OFFSET, LARGEST_OFFSET) * POOL_BALL_RADIUS
    return racked(f"made-{number}", (speed, 0.0), offset, gap, TABLE)


@benchmark
def made_balls(count: Count = BREAKS) -> MadeBallsMeasurement:
    """Count the breaks on a bar table that pocket a ball; compare with published counts."""
    made = scratched = pocketed = 0
    for number in with_progress(range(count), lambda _: "breaks"):
        events = simulate(break_of(number), record="events").events
        assert events is not None
        fell = events["a"][events["kind"] == EventKind.POCKETED]
        made += bool((fell > 0).any())
        scratched += bool((fell == 0).any())
        pocketed += len(fell)
    return MadeBallsMeasurement(breaks=count, made=made, scratched=scratched, pocketed=pocketed)
