"""Predict the motion of every ball that an event has changed.

A ball is predicted alone, until its own next event (`motion.next_piece`), or together with balls in
resting contact (`resting_contact.step`).
"""

from __future__ import annotations

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import World
from ghostball.engine.impacts.lying_still import let_go_above
from ghostball.engine.motion.geometry import at_rest
from ghostball.engine.motion.next_piece import predict_motion
from ghostball.engine.resting_contact.step import end_step, start_steps


@kernel(inline=True)
def predict(world: World, held: int, t: float) -> None:
    """Predict the motion of every marked ball from the time t [s] on.

    Also start contact steps, for the first `held` contacts of `balls.touching`, and for all other
    balls that friction presses together.
    """
    _predict_marked(world)
    if held > 0 or world.contacts.waiting[0] > 0:
        start_steps(world, held, t)
    if world.balls.height is not None:
        let_go_above(world.balls.height, world.balls, world.laws, t)


@kernel(inline=True)
def _predict_marked(world: World) -> None:
    """Predict every marked ball, because an event has set its velocity.

    A ball in a contact step is left to `start_steps`: its step ends here.
    """
    balls, contacts = world.balls, world.contacts
    for m in range(1, balls.touched[0] + 1):
        i = balls.touched[m]
        if not at_rest(balls, i):
            balls.state[i].moved = 1.0
        contacts.motion[i].step = 0.0
        contacts.motion[i].ahead = 0.0
        if contacts.island[i] != st.FREE:
            end_step(contacts, i)
            continue
        if balls.own_kind[i] == st.OWN_LEG:
            continue  # `event_loop.compression` has set its piece
        predict_motion(balls, i, world.laws)
