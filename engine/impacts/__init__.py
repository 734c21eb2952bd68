"""Impacts: on the cloth (`impact`), in scenes with flight (`in_space`), and several at once.

`simultaneous` resolves simultaneous impacts that share a ball; `contact_solver` computes their
impulses, and the forces of resting contacts. `laws` has the laws of a single impact on the cloth.
"""
