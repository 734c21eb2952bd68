"""Resting contact: balls that friction holds together, the forces between them, their steps.

`step` has the whole. Balls in contact are an island (`islands`), each a member of it.
While all contacts push, its motion is integrated far: `continuation`, `integrate`, by the forces of
`rates`, along `paths`. Else it goes in short steps, by those of `forces`, `friction` and
`cloth_response`. `gaps` are kept closed by both; `capture` takes away what approach there is at the
start.
"""
