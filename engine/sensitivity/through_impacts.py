"""What an impact does to small changes of its balls' motion: the derivative of its law.

That is a central difference, of every law (`sensitivity.through_laws`).
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import FloatArray
from ghostball.engine.impacts.laws.dispatch import ball_law, cushion_law
from ghostball.engine.impacts.laws.interface import BallImpact
from ghostball.engine.motion.obstacles import facing, row_at, turning
from ghostball.engine.sensitivity import state as ts
from ghostball.engine.sensitivity.between_events import shift_before
from ghostball.engine.sensitivity.state import Tangents
from ghostball.engine.sensitivity.through_laws import (
    cushion_impact,
    put_ball_law,
    put_cushion_law,
)


@kernel(inline=True)
def pass_impact(run: Tangents, i: int, j: int) -> None:
    """Take the perturbations of balls i and j through their impact.

    Contract: both have arrived, i in the first row and j in the second; they are left where and
    when the event is for each perturbation, just after it.

    dtau is n . dr over the approach. The perturbed balls touch along a normal that is turned by
    t . dr / |r|, and in its frame the law gives what it makes of what they bring to it.
    """
    ki, kj = run.at[i] + 1, run.at[j] + 1
    rx, ry = (
        run.segments[kj, st.X] - run.segments[ki, st.X],
        run.segments[kj, st.Y] - run.segments[ki, st.Y],
    )
    distance = math.sqrt(rx * rx + ry * ry)
    nx, ny = rx / distance, ry / distance
    vx = run.motion[0, ts.PRE_VX] - run.motion[1, ts.PRE_VX]
    vy = run.motion[0, ts.PRE_VY] - run.motion[1, ts.PRE_VY]
    along_n, along_t = nx * vx + ny * vy, nx * vy - ny * vx
    _meet(run.lanes, run.work, nx / along_n, ny / along_n, nx, ny, 1.0 / distance, along_t)
    shift_before(run, 0)
    shift_before(run, 1)
    impact = _to_contact_frame(run, i, j, nx, ny)
    _see(
        run.lanes,
        run.work[ts.FIRST_BALL :],
        ts.THETA,
        ts.FRAME,
        nx,
        ny,
        impact.a_vn,
        impact.a_vt,
        impact.a_wn,
        impact.a_wt,
    )
    _see(
        run.lanes,
        run.work[ts.SECOND_BALL :],
        ts.THETA - ts.ROW_LENGTH,
        ts.FRAME + 5 * ts.LANES - ts.ROW_LENGTH,
        nx,
        ny,
        impact.b_vn,
        impact.b_vt,
        impact.b_wn,
        impact.b_wt,
    )
    _pass_law(run, impact, i, j, nx, ny)


@kernel(inline=True)
def _meet(
    lanes: int,
    work: FloatArray,
    by_x: float,
    by_y: float,
    nx: float,
    ny: float,
    over_distance: float,
    along_t: float,
) -> None:
    """Put in `work` by how much later each perturbed pair touches, and how their normal turns."""
    for lane in range(lanes):
        rx = work[ts.SECOND_BALL + ts.DX + lane] - work[ts.FIRST_BALL + ts.DX + lane]
        ry = work[ts.SECOND_BALL + ts.DY + lane] - work[ts.FIRST_BALL + ts.DY + lane]
        tau = by_x * rx + by_y * ry
        work[ts.TAU + lane] = tau
        work[ts.THETA + lane] = over_distance * (nx * ry - ny * rx - tau * along_t)


@kernel(inline=True)
def _to_contact_frame(run: Tangents, i: int, j: int, nx: float, ny: float) -> BallImpact:
    """Return both balls just before the impact in the frame of their contact."""
    motion, state = run.motion, run.state
    return BallImpact(
        nx * motion[0, ts.PRE_VX] + ny * motion[0, ts.PRE_VY],
        nx * motion[0, ts.PRE_VY] - ny * motion[0, ts.PRE_VX],
        nx * motion[0, ts.PRE_WX] + ny * motion[0, ts.PRE_WY],
        nx * motion[0, ts.PRE_WY] - ny * motion[0, ts.PRE_WX],
        motion[0, ts.PRE_WZ],
        state[i, st.RADIUS],
        state[i, st.MASS],
        state[i, st.CLOTH_FRICTION],
        nx * motion[1, ts.PRE_VX] + ny * motion[1, ts.PRE_VY],
        nx * motion[1, ts.PRE_VY] - ny * motion[1, ts.PRE_VX],
        nx * motion[1, ts.PRE_WX] + ny * motion[1, ts.PRE_WY],
        nx * motion[1, ts.PRE_WY] - ny * motion[1, ts.PRE_WX],
        motion[1, ts.PRE_WZ],
        state[j, st.RADIUS],
        state[j, st.MASS],
        state[j, st.CLOTH_FRICTION],
    )


@kernel(inline=True)
def _see(
    lanes: int,
    row: FloatArray,
    theta_at: int,
    seen_at: int,
    nx: float,
    ny: float,
    vn: float,
    vt: float,
    wn: float,
    wt: float,
) -> None:
    """Put at `seen_at` the perturbation of a ball in the frame of the contact, which turns too."""
    for lane in range(lanes):
        theta = row[theta_at + lane]
        vx, vy = row[ts.DVX + lane], row[ts.DVY + lane]
        wx, wy = row[ts.DWX + lane], row[ts.DWY + lane]
        row[seen_at + ts.A_VN * ts.LANES + lane] = nx * vx + ny * vy + vt * theta
        row[seen_at + ts.A_VT * ts.LANES + lane] = nx * vy - ny * vx - vn * theta
        row[seen_at + ts.A_WN * ts.LANES + lane] = nx * wx + ny * wy + wt * theta
        row[seen_at + ts.A_WT * ts.LANES + lane] = nx * wy - ny * wx - wn * theta
        row[seen_at + ts.A_WZ * ts.LANES + lane] = row[ts.DWZ + lane]


@kernel(inline=True)
def _pass_law(run: Tangents, impact: BallImpact, i: int, j: int, nx: float, ny: float) -> None:
    """Change the perturbations of balls i and j by what the law gives."""
    impulse = ball_law(impact, run.laws)
    put_ball_law(run, impact)
    _apply_law(run, ts.LAW_OUT, ts.LAW_IN)
    _rub_cloth(run, i, 0, nx, ny, impulse.a_cloth_n, impulse.a_cloth_t)
    _rub_cloth(run, j, 1, nx, ny, impulse.b_cloth_n, impulse.b_cloth_t)
    total = run.state[i, st.MASS] + run.state[j, st.MASS]
    to_i, to_j = run.state[j, st.MASS] / total, run.state[i, st.MASS] / total
    turn_i, turn_j = 2.5 * to_i / run.state[i, st.RADIUS], 2.5 * to_j / run.state[j, st.RADIUS]
    normal, along, up = impulse.normal, impulse.along, impulse.up
    _push(run.lanes, run.work[ts.FIRST_BALL :], 0, -to_i, turn_i, nx, ny, normal, along, up)
    _push(
        run.lanes,
        run.work[ts.SECOND_BALL :],
        ts.ROW_LENGTH,
        to_j,
        turn_j,
        nx,
        ny,
        normal,
        along,
        up,
    )


@kernel(inline=True)
def _push(
    lanes: int,
    row: FloatArray,
    before: int,
    push: float,
    turn: float,
    nx: float,
    ny: float,
    normal: float,
    along: float,
    up: float,
) -> None:
    """Add the perturbation of the impulse, in its frame that turns, to a ball's.

    `before` is how far into `work` the ball's row is. The impulse's parts are along n and t, and
    up; where n turns by theta t, t turns by -theta n.
    """
    for lane in range(lanes):
        theta = row[ts.THETA - before + lane]
        d_along = row[ts.GIVEN - before + ts.LANES + lane]
        d_up = row[ts.GIVEN - before + 2 * ts.LANES + lane]
        en = row[ts.GIVEN - before + lane] - along * theta
        et = d_along + normal * theta
        row[ts.DVX + lane] += push * (nx * en - ny * et)
        row[ts.DVY + lane] += push * (ny * en + nx * et)
        row[ts.DWX + lane] -= turn * (ny * d_up + nx * up * theta)
        row[ts.DWY + lane] += turn * (nx * d_up - ny * up * theta)
        row[ts.DWZ + lane] -= turn * d_along


@kernel
def _rub_cloth(
    run: Tangents, k: int, index: int, nx: float, ny: float, cloth_n: float, cloth_t: float
) -> None:
    """Add to the perturbation of ball k that of the cloth's impulse on it."""
    turn = 2.5 / run.state[k, st.RADIUS]
    at, row = ts.GIVEN + (3 + 2 * index) * ts.LANES, index * ts.ROW_LENGTH
    for lane in range(run.lanes):
        theta = run.work[ts.THETA + lane]
        cn = run.work[at + lane] - cloth_t * theta
        ct = run.work[at + ts.LANES + lane] + cloth_n * theta
        cx, cy = nx * cn - ny * ct, ny * cn + nx * ct
        run.work[row + ts.DVX + lane] += cx
        run.work[row + ts.DVY + lane] += cy
        run.work[row + ts.DWX + lane] += turn * cy
        run.work[row + ts.DWY + lane] -= turn * cx


@kernel
def _apply_law(run: Tangents, rows: int, columns: int) -> None:
    """Put at GIVEN what the law makes of what is at FRAME, to first order."""
    for row in range(rows):
        at = ts.GIVEN + row * ts.LANES
        for lane in range(run.lanes):
            run.work[at + lane] = 0.0
        for column in range(columns):
            factor = run.law[row, column]
            for lane in range(run.lanes):
                run.work[at + lane] += factor * run.work[ts.FRAME + column * ts.LANES + lane]


@kernel(inline=True)
def pass_cushion(run: Tangents, ball: int, cushion: int) -> None:
    """Take the perturbation of a ball, in the first row, through its impact with a cushion.

    Contract: as `pass_impact`. What it meets is like a ball that rests, whose surface may be flat.
    """
    row, nx, ny = _meet_obstacle(run, ball, cushion, False)
    shift_before(run, 0)
    impact = cushion_impact(run, ball, nx, ny)
    after = cushion_law(impact, run.laws, row)
    put_cushion_law(run, impact, row)
    work = run.work
    _see(
        run.lanes,
        work,
        ts.THETA,
        ts.FRAME,
        nx,
        ny,
        impact.vn,
        impact.vt,
        impact.wn,
        impact.wt,
    )
    _apply_law(run, ts.B_VN, ts.B_VN)
    for lane in range(run.lanes):
        # Where n turns by theta t, t turns by -theta n.
        theta = work[ts.THETA + lane]
        vn = work[ts.GIVEN + ts.A_VN * ts.LANES + lane] - after.vt * theta
        vt = work[ts.GIVEN + ts.A_VT * ts.LANES + lane] + after.vn * theta
        wn = work[ts.GIVEN + ts.A_WN * ts.LANES + lane] - after.wt * theta
        wt = work[ts.GIVEN + ts.A_WT * ts.LANES + lane] + after.wn * theta
        work[ts.DVX + lane] = nx * vn - ny * vt
        work[ts.DVY + lane] = ny * vn + nx * vt
        work[ts.DWX + lane] = nx * wn - ny * wt
        work[ts.DWY + lane] = ny * wn + nx * wt
        work[ts.DWZ + lane] = work[ts.GIVEN + ts.A_WZ * ts.LANES + lane]


@kernel(inline=True)
def pass_pocket(run: Tangents, ball: int, pocket: int) -> None:
    """Take the perturbation of a ball, in the first row, to where its centre enters a hole.

    Contract: as `pass_impact`. There it stays.
    """
    _meet_obstacle(run, ball, pocket, True)
    shift_before(run, 0)
    for lane in range(run.lanes):
        run.work[ts.DVX + lane] = 0.0
        run.work[ts.DVY + lane] = 0.0
        run.work[ts.DWX + lane] = 0.0
        run.work[ts.DWY + lane] = 0.0
        run.work[ts.DWZ + lane] = 0.0


@kernel(inline=True)
def _meet_obstacle(
    run: Tangents, ball: int, index: int, takes_out: bool
) -> tuple[int, float, float]:
    """Put in `work` by how much later a perturbed ball meets an obstacle, and how its normal turns.

    Returns the obstacle's row, and the unit normal from the ball to it.
    """
    k = run.at[ball] + 1
    x, y = run.segments[k, st.X], run.segments[k, st.Y]
    row = row_at(run.laws, index, takes_out, x, y)
    inward_x, inward_y, _ = facing(run.laws, row, x, y)
    turns = turning(run.laws, row, x, y)
    nx, ny = -inward_x, -inward_y
    vx, vy = run.motion[0, ts.PRE_VX], run.motion[0, ts.PRE_VY]
    approach, along = nx * vx + ny * vy, nx * vy - ny * vx
    work, by_x, by_y = run.work, -nx / approach, -ny / approach
    for lane in range(run.lanes):
        dx, dy = work[ts.DX + lane], work[ts.DY + lane]
        tau = by_x * dx + by_y * dy
        work[ts.TAU + lane] = tau
        work[ts.THETA + lane] = -turns * (nx * dy - ny * dx + tau * along)
    return row, nx, ny
