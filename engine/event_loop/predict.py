"""Predicts anew, after an event, the motion of every ball that it changed.

Each alone, until its own next event (`motion.next_piece`), or with others that friction holds it
together with (`resting_contact.step`).
"""

from __future__ import annotations

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    AHEAD,
    FREE,
    STEP,
    Balls,
    Cells,
    Contacts,
    FloatArray,
    IntArray,
    Laws,
)
from ghostball.engine.impacts.slow_impacts import let_go_above
from ghostball.engine.motion.geometry import (
    at_rest,
)
from ghostball.engine.motion.next_piece import predict_motion
from ghostball.engine.resting_contact.step import end_step, press_again


@kernel(inline=True)
def predict(
    balls: Balls,
    laws: Laws,
    cells: Cells | None,
    contacts: Contacts | None,
    held: int,
    t: float,
    counters: IntArray,
) -> None:
    """Predict every ball that is marked, at the instant t: its old motion is void.

    And start contact steps: of the first `held` contacts of `balls.hits`, and where else balls
    press each other.
    """
    _predict_marked(balls, laws, contacts)
    if contacts is not None:
        press_again(balls, laws, cells, contacts, held, t, counters)
    _let_go_above(balls.height, balls, laws, t)


@kernel(inline=True)
def _let_go_above(height: FloatArray | None, balls: Balls, laws: Laws, t: float) -> None:
    """Let balls fall that lie still on what moves, if there are any."""
    if height is not None:
        let_go_above(height, balls, laws, t)


@kernel(inline=True)
def _predict_marked(balls: Balls, laws: Laws, contacts: Contacts | None) -> None:
    """Predict every ball that is marked, since an event set its velocity.

    One in a contact step is left to `press_again`: its step ends here.
    """
    for m in range(1, balls.touched[0] + 1):
        i = balls.touched[m]
        if not at_rest(balls, i):
            balls.state[i].moved = 1.0
        if contacts is not None:
            contacts.motion[i, STEP] = 0.0
            contacts.motion[i, AHEAD] = 0.0
            if contacts.cluster[i] != FREE:
                end_step(contacts, i)
                continue
        predict_motion(balls, i, laws)
