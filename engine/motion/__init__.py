"""The motion of one ball until its next event, and the obstacles that it reaches.

`position` gives position and velocity at a time; `next_piece`, `drag` and `flight` predict the next
piece of the motion, and `obstacles` the obstacles that it reaches. `geometry` finds neighbours and
contacts, `crossings` the roots of gaps.
"""
