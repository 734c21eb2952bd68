"""Resting contact: balls that friction holds together, and the forces between them.

`step` has the main code. Balls in contact form an island (`islands`); the balls are its members.
While all contacts push, the motion of an island is integrated with high order (`continuation`,
`integrate`), with the forces of `rates`, along `paths`. Otherwise it moves in short steps, with the
forces of `forces`, `friction` and `cloth_response`. Both keep the gaps closed (`gaps`); `capture`
removes the approach that remains at the start.
"""
