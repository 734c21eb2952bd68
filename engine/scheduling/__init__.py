"""Predict which pairs of balls touch next, and when.

`scheduler` is the interface that the event loop uses. It has two implementations: `all_pairs` for
few balls, and `broad_phase` (with `grid` and `priority_queue`) for many. `time_of_impact` computes
when two balls touch, `due_pairs` decides which pairs do, and `ties` orders events of equal time.
"""
