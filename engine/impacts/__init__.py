"""Impacts: on the cloth (`impact`), in scenes with flight (`in_space`), and several at once.

`simultaneous` resolves simultaneous impacts that share a ball; `contact_solver` computes their
impulses, and the forces of resting contacts. `laws` has the laws of a single impact on the cloth.
`compliant` integrates impacts that last. `on_table` has the response of the table in flight;
`slow_impacts` and `lying_still` treat balls on top of other balls.
"""
