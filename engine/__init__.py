"""The in-house continuous-collision engine.

    >>> from ghostball import Ball, Scene, simulate
    >>> scene = Scene(name="roll", balls=[Ball(id="cue", position=(0, 0), velocity=(1, 0))])
    >>> simulate(scene).rest_time
    5.098...

Its names, listed in `__init__.pyi`, are imported when they are asked for. Importing them compiles
nothing and loads no compiler: that waits for the first `simulate`.

Geometry
--------
The table lies in the plane z = 0, from (0, 0) to (length, width). Balls move in the plane of their
centres: two touch where their centres are the sum of their radii apart in that plane, also when the
radii differ, as in the paper; a ball touches a cushion where its centre is a radius away from it,
whatever the height of the nose, which only some laws of impacts use. Where balls may leave the
cloth, all of this is in space: see "Flight".

Motion
------
With `motion` = "rolling", the paper's model, a ball always rolls without slip: its velocity gives
its spin, and it slows down at `rolling_friction` times `gravity` until it rests. With "sliding",
spin is a state of its own. The lowest point of a ball slips over the cloth at u = (vx - R wy,
vy + R wx). While u isn't 0 the ball slides: friction `sliding_friction` times its weight acts
against u, whose direction never changes, so that the centre follows a parabola and the slip ends
in a time known beforehand; then the ball rolls. Spin about the vertical decays steadily, at
`spinning_friction_rate`, as long as the ball is on the cloth, and moves nothing until an impact. A
ball may have frictions of its own.

With `air_drag`, or `rolling_friction_quadratic`, balls are slowed by more the faster they are, and
such a motion is no parabola (`engine/motion/drag.py`).

Impacts
-------
They take no time. `Physics.ball_impact` and `Physics.cushion` name the law of each kind
(`ghostball/model/impact_laws.py` lists them), and `Physics.impacts` says whether those of
balls that share one at one instant are resolved together, so that no order of balls matters, or one
after another; together, balls rub by Coulomb's law, whatever `ball_impact` is. Both cushions of a
corner are met together too; a cushion and a ball at one instant, the cushion first. Impulses along
the vertical turn balls and never lift them, unless `airborne` is true. Laws that act through spin
need `motion` = "sliding".

Flight
------
With `airborne` = true a ball may begin above the cloth, or be lifted by an impact. It goes along a
parabola (`engine/motion/flight.py`), or as air lets it (`engine/motion/flight_in_air.py`). It
bounces where it lands, `table_restitution` says how high, and may fly over a cushion and off the
table. Contacts are where the surfaces meet in space, that with a cushion at its nose,
`cushion_height` above the cloth. Impacts have the scene's restitution and friction, but follow no
law by name, unless they are too slow to lift a ball (`engine/impacts/in_space.py`).

Sustained contact
-----------------
Balls that friction pushes together don't bounce without end: contact forces hold their gaps closed
for as long as they push, in steps that keep every gap within a tolerance
(`engine/resting_contact/step.py`).
"""

import lazy_loader

if not __name__.startswith("ghostball."):  # else there were two of each class
    raise ImportError(
        f"this package is part of ghostball: import `ghostball.{__name__}`, or "
        "`from ghostball import Scene, simulate`"
    )

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
