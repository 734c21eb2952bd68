"""Derivatives of the laws of impacts, by central differences: a new law needs nothing here."""

from __future__ import annotations

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.impacts.laws.dispatch import ball_law, cushion_law
from ghostball.engine.impacts.laws.interface import BallImpact, CushionImpact
from ghostball.engine.sensitivity import state as ts
from ghostball.engine.sensitivity.state import Tangents

_STEP = 2.0**-14
"""Of a central difference, over the largest speed: its error is some 1e-8 of the derivative, or
1e-5 where a law integrates, whose own error of 1e-9 it divides."""


@kernel
def put_ball_law(run: Tangents, impact: BallImpact) -> None:
    """Put the derivative of the balls' law in `run.law`, by central differences."""
    speed = max(
        abs(impact.a_vn) + abs(impact.a_vt),
        abs(impact.b_vn) + abs(impact.b_vt),
        impact.a_radius * (abs(impact.a_wn) + abs(impact.a_wt) + abs(impact.a_wz)),
        impact.b_radius * (abs(impact.b_wn) + abs(impact.b_wt) + abs(impact.b_wz)),
    )
    for column in range(ts.LAW_IN):
        radius = impact.a_radius if column < ts.B_VN else impact.b_radius
        step = _STEP * speed if column % ts.B_VN < ts.A_WN else _STEP * speed / radius
        after = ball_law(_with_ball_step(impact, column, step), run.laws)
        before = ball_law(_with_ball_step(impact, column, -step), run.laws)
        over = 0.5 / step
        run.law[0, column] = over * (after.normal - before.normal)
        run.law[1, column] = over * (after.along - before.along)
        run.law[2, column] = over * (after.up - before.up)
        run.law[3, column] = over * (after.a_cloth_n - before.a_cloth_n)
        run.law[4, column] = over * (after.a_cloth_t - before.a_cloth_t)
        run.law[5, column] = over * (after.b_cloth_n - before.b_cloth_n)
        run.law[6, column] = over * (after.b_cloth_t - before.b_cloth_t)


@kernel
def _with_ball_step(impact: BallImpact, column: int, step: float) -> BallImpact:
    """Return the impact with `step` added to one of the numbers that a perturbation changes."""
    return BallImpact(
        impact.a_vn + (step if column == ts.A_VN else 0.0),
        impact.a_vt + (step if column == ts.A_VT else 0.0),
        impact.a_wn + (step if column == ts.A_WN else 0.0),
        impact.a_wt + (step if column == ts.A_WT else 0.0),
        impact.a_wz + (step if column == ts.A_WZ else 0.0),
        impact.a_radius,
        impact.a_mass,
        impact.a_cloth,
        impact.b_vn + (step if column == ts.B_VN else 0.0),
        impact.b_vt + (step if column == ts.B_VT else 0.0),
        impact.b_wn + (step if column == ts.B_WN else 0.0),
        impact.b_wt + (step if column == ts.B_WT else 0.0),
        impact.b_wz + (step if column == ts.B_WZ else 0.0),
        impact.b_radius,
        impact.b_mass,
        impact.b_cloth,
    )


@kernel(inline=True)
def cushion_impact(run: Tangents, ball: int, nx: float, ny: float) -> CushionImpact:
    """Return a ball just before it meets a cushion, in the frame of the contact."""
    motion, state = run.motion, run.state
    return CushionImpact(
        nx * motion[0, ts.PRE_VX] + ny * motion[0, ts.PRE_VY],
        nx * motion[0, ts.PRE_VY] - ny * motion[0, ts.PRE_VX],
        nx * motion[0, ts.PRE_WX] + ny * motion[0, ts.PRE_WY],
        nx * motion[0, ts.PRE_WY] - ny * motion[0, ts.PRE_WX],
        motion[0, ts.PRE_WZ],
        state[ball, st.RADIUS],
        state[ball, st.MASS],
        state[ball, st.CLOTH_FRICTION],
    )


@kernel(inline=True)
def put_cushion_law(run: Tangents, impact: CushionImpact, k: int) -> None:
    """Put the derivative of obstacle k's law in `run.law`."""
    speed = max(
        abs(impact.vn) + abs(impact.vt),
        impact.radius * (abs(impact.wn) + abs(impact.wt) + abs(impact.wz)),
    )
    for column in range(ts.B_VN):
        # No law is defined for a ball that leaves: the step along n is a part of the approach.
        step = _STEP * speed if column > ts.A_VN else _STEP * impact.vn
        step = step / impact.radius if column > ts.A_VT else step
        after = cushion_law(_with_cushion_step(impact, column, step), run.laws, k)
        before = cushion_law(_with_cushion_step(impact, column, -step), run.laws, k)
        over = 0.5 / step
        run.law[ts.A_VN, column] = over * (after.vn - before.vn)
        run.law[ts.A_VT, column] = over * (after.vt - before.vt)
        run.law[ts.A_WN, column] = over * (after.wn - before.wn)
        run.law[ts.A_WT, column] = over * (after.wt - before.wt)
        run.law[ts.A_WZ, column] = over * (after.wz - before.wz)


@kernel
def _with_cushion_step(impact: CushionImpact, column: int, step: float) -> CushionImpact:
    """Return the impact with `step` added to one of the numbers that a perturbation changes."""
    return CushionImpact(
        impact.vn + (step if column == ts.A_VN else 0.0),
        impact.vt + (step if column == ts.A_VT else 0.0),
        impact.wn + (step if column == ts.A_WN else 0.0),
        impact.wt + (step if column == ts.A_WT else 0.0),
        impact.wz + (step if column == ts.A_WZ else 0.0),
        impact.radius,
        impact.mass,
        impact.cloth,
    )
