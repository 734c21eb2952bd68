"""The loop from event to event: what comes next, what it does, what is recorded of it.

`loop` is the loop; its turns are `find`, `resolve`, `predict` and `record`, its end is `finish`.
Python calls it by `play`, for one shot as for many.
"""
