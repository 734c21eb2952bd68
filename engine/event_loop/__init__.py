"""The event loop: find the next event, resolve it, predict new motions, and record them.

`loop` has the loop; its steps are in `find`, `resolve`, `predict` and `record`, its end in
`finish`. Python calls it through `play`, for one shot or many.
"""
