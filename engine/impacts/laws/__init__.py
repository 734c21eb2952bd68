"""What one impact on the cloth does: a function for each law, chosen by name in the scene.

`model.impact_laws` names the laws; `interface` is the one signature that each kind of law has;
`dispatch` calls the law that a scene chose. The laws are in `ball_...` and `cushion_...`; what they
share, in `friction_curve` and, of those that integrate over the impact, in `two_contacts` and
`impulse_integrator`.

To add a law, write its function, name it in `model.impact_laws` and give it its branch in
`dispatch`; where other engines may lack it, name its feature in `model.features`. A coefficient of
its own is a field of `model.scene.Physics` and of `core.state.Laws`, which `running.from_scene`
fills and `event_loop.entry` unpacks.

Not all that balls do asks a law. Joint impacts (`impacts.simultaneous`), impacts where balls may
leave the cloth (`impacts.in_space`) and contacts that last (`resting_contact`) have rules of their
own, with the same coefficients: a new law has to suit them, or `model.scene.law_rules` has to
refuse it there.
"""
