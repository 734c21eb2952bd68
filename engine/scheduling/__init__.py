"""What comes next: times of impact of every pair for few balls, a broad phase by cells for many.

`scheduler` is what the loop calls of either: `all_pairs`; or `broad_phase`, with `grid` and
`priority_queue`. `time_of_impact` is when two balls touch, `due_pairs` which pairs do, and `ties`
who comes first.
"""
