"""The laws of a single impact on the cloth: one function per law, chosen by name in the scene.

`model.impact_laws` names the laws; `interface` defines the signature of each kind of law;
`dispatch` calls the law that a scene has chosen. The laws are in `ball_...` and `cushion_...`; the
code they share is in `friction_curve` and, for laws that integrate over the impact, in
`two_contacts` and `impulse_integrator`.

To add a law, write its function, name it in `model.impact_laws`, and add a branch to `dispatch`. If
other engines may lack the law, name its feature in `model.features`. A coefficient of its own is a
field of `model.scene.Physics` and of `core.state.Laws`, which `running.from_scene` fills and
`event_loop.play` unpacks.

Some contacts don't use a law. Simultaneous impacts (`impacts.simultaneous`), impacts in scenes with
flight (`impacts.in_space`) and resting contacts (`resting_contact`) have rules of their own, with
the same coefficients. A new law must suit them, or `model.scene.law_rules` must refuse it there.
"""
