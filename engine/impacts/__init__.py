"""What impacts do: on the cloth (`impact`), where balls may fly (`in_space`), several at once.

Several that share a ball at one instant are `simultaneous`; `contact_solver` finds their impulses,
and the forces of contacts that last, too. `laws` has what a single impact on the cloth does.
"""
