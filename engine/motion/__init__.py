"""How a ball moves until something happens to it, and what it meets on its way.

`position` has where it is at an instant; `next_piece`, `drag` and `flight` predict how it moves on,
and `obstacles` what stands in its way. `geometry` has what is near and what touches, `crossings`
roots.
"""
