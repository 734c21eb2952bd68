"""Tests that every registered law is called, with the constants of the scene."""

from __future__ import annotations

import numpy as np
from kernels import entry_to

from ghostball.engine.core.kernel import COMPILED
from ghostball.engine.core.rows import OBSTACLE, OBSTACLE_COLUMNS, ObstacleRow, rows_of
from ghostball.engine.core.state import Laws
from ghostball.engine.event_loop.play import laws_from
from ghostball.engine.impacts.laws.dispatch import ball_law, cushion_law
from ghostball.engine.impacts.laws.interface import BallImpact, BallInFrame
from ghostball.model.impact_laws import BALL_LAWS, CUSHION_LAW_NAMES, CUSHION_LAWS

NUMBERS = Laws._fields[:-1]
NOTHING = Laws(*(0.0,) * len(NUMBERS), obstacles=np.empty(0, dtype=OBSTACLE))


def test_every_law_of_the_registry_is_called():
    """If `dispatch` didn't know a law, it would silently call another one."""
    cushions = np.zeros(len(CUSHION_LAWS), dtype=OBSTACLE)
    cushions["law"] = np.arange(len(CUSHION_LAWS))
    cushions["restitution"], cushions["tangential"] = 0.8, 0.7
    cushions["friction"], cushions["height"] = 0.6, 0.036
    cushions["ratio"][CUSHION_LAW_NAMES.index("stronge2000")] = 1.76
    matrix = cushions.view(np.float64).reshape(-1, OBSTACLE_COLUMNS)
    laws = NOTHING._replace(
        slides=1.0, ball_restitution=0.9, ball_friction=0.1,
        obstacles=cushions if COMPILED else rows_of(matrix, ObstacleRow),
    )  # fmt: skip
    ball = (0.028, 0.17, 0.2)
    impact = BallImpact(
        BallInFrame(1.0, 0.3, 5.0, 20.0, 30.0, *ball), BallInFrame(-0.5, 0.2, 1.0, 2.0, 3.0, *ball)
    )
    bounce = BallInFrame(1.0, 0.4, 3.0, 20.0, 10.0, *ball)
    kernels = {"ball": (entry_to(ball_law), impact), "cushion": (entry_to(cushion_law), bounce)}
    for kind, registry in (("ball", BALL_LAWS), ("cushion", CUSHION_LAWS)):
        kernel, impact = kernels[kind]
        found = set()
        for code, law in enumerate(registry):
            if law.name == "mirror":
                continue  # "mirror" is the law `restitution` with factors of 1
            one = laws._replace(ball_law=float(code))
            numbers = laws_from(np.array(one[:-1], dtype=np.float64), one.obstacles)
            more = () if kind == "ball" else (code,)
            found.add(tuple(kernel(impact, numbers, *more)))
        assert len(found) == len(registry) - (kind == "cushion")
