"""How often a break makes a ball, beside 118 breaks of professionals: a check of sanity, no grade.

Published counts (Alciatore's site, "8-ball break statistics") say neither how fast the cue balls
were nor how tight the racks: both are assumed here, so that a wide band is all that can be asked.
"""

from __future__ import annotations

import math
import random
from typing import Final, Literal

from rich.console import RenderableType

from benchmarks.frame import Count, benchmark, counted
from benchmarks.measurements import Shown, table_of
from benchmarks.scenes import racked
from ghostball.engine import simulate
from ghostball.model import POOL_BALL_RADIUS, EventKind, Scene, Table

BREAKS = 4_000
"""Breaks of a whole measurement: the standard error of a share of 80 % is 0.6 %."""

TABLE: Final = Table.model_validate("bar-7ft")

SPEEDS: Final = (7.0, 11.0)
"""Assumed: the speed of a cue ball at a break [m/s]."""

LOOSEST: Final = 0.5e-3
"""Assumed: the widest gap of a rack [m]."""

OFF_CENTRE: Final = 0.15
"""Assumed: how far off full the first ball is met, at most, in radii."""

PUBLISHED: Final = {"made": (0.805, 118), "scratch": (0.076, 118)}
"""Share of breaks in which a ball was made, and in which the cue ball fell; of how many breaks."""


class MadeMeasurement(Shown):
    """What `python -m benchmarks made` counted.

    `made`: breaks in which a ball other than the cue ball was pocketed.
    `scratched`: those in which the cue ball was.
    """

    kind: Literal["made"] = "made"
    breaks: int
    made: int
    scratched: int
    pocketed: int

    @property
    def table(self) -> RenderableType:
        """Shares, beside the published ones with a standard error each."""
        return table_of(("breaks", f"of {self.breaks} here", "published"), self.rows)

    @property
    def rows(self) -> list[tuple[str, str, str]]:
        """What a break did, how often it did here, and in the published ones."""
        rows = []
        for name, count in (("made", self.made), ("scratch", self.scratched)):
            share, of = PUBLISHED[name]
            error = math.sqrt(share * (1.0 - share) / of)
            rows.append((name, f"{count / self.breaks:.1%}", f"{share:.1%} ± {error:.1%}"))
        return rows


def break_of(number: int) -> Scene:
    """Return an eight-ball break on a bar table; the same number is the same break."""
    chance = random.Random(f"made {number}")
    gap = chance.uniform(0.0, LOOSEST)
    speed = chance.uniform(*SPEEDS)
    offset = chance.uniform(-OFF_CENTRE, OFF_CENTRE) * POOL_BALL_RADIUS
    return racked(f"made-{number}", (speed, 0.0), offset, gap, TABLE)


@benchmark
def made(count: Count = BREAKS) -> MadeMeasurement:
    """Count how often a break on a bar table makes a ball, beside published counts."""
    made = scratched = pocketed = 0
    for number in counted(range(count), lambda _: "breaks"):
        events = simulate(break_of(number), record="events").events
        assert events is not None
        fell = events["a"][events["kind"] == EventKind.POCKETED]
        made += bool((fell > 0).any())
        scratched += bool((fell == 0).any())
        pocketed += len(fell)
    return MadeMeasurement(breaks=count, made=made, scratched=scratched, pocketed=pocketed)
