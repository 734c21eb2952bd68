"""Ghostball's own engine: billiards in continuous time, without a time step.

    >>> from ghostball import Ball, Scene, simulate
    >>> scene = Scene(name="roll", balls=[Ball(id="cue", position=(0, 0), velocity=(1, 0))])
    >>> simulate(scene).rest_time
    5.098...

Between two events every ball moves along a known curve. The engine computes the time of the next
event (a collision, a slide that becomes a roll, a ball that stops), moves the balls of the event to
this time, and resolves the event.

Where to find what
------------------
`shot`, `batch`, `sweep`, `starts`, `strokes`, `needed_kernels`: the public functions and classes.
`__init__.pyi` lists their names, which are imported when they are used.
`event_loop`: the loop; one file for each of its steps (find, resolve, predict, record).
`motion`: the curve of one ball up to its next event, and the gaps between balls and obstacles.
`scheduling`: the next collision of every pair.
`impacts`: the effect of a collision on velocities and spins; `impacts/laws` has the impact laws.
`resting_contact`: balls that friction holds together.
`sensitivity`: the growth of small changes of a shot.
`running`: conversion of a scene to arrays, and of the arrays to a result.
`library`: compiled kernels. Importing this package compiles nothing; the first `simulate` does.

Coordinates
-----------
SI units. The table is the plane z = 0 from (0, 0) to (length, width); z points up. Two balls touch
when the distance of their centres, measured in the plane, is the sum of their radii; this also
holds for balls of different radii, as in the paper. A ball touches a cushion when its centre is one
radius away from it. The height of the cushion nose only matters to some impact laws. With
`airborne`, all distances are measured in space instead.

Motion
------
`motion` = "rolling" (the paper's model): balls never slip. Spin follows from velocity, and a ball
decelerates at `rolling_friction` times `gravity` until it stops.

`motion` = "sliding": spin is independent of velocity. The lowest point of a ball moves over the
cloth with the slip velocity u = (vx - R wy, vy + R wx).

- While u isn't 0, a friction of `sliding_friction` times the ball's weight acts against u. The
  direction of u is constant, so the centre moves along a parabola, and the time at which u reaches
  0 is known.
- Then the ball rolls.
- Spin about the vertical decays at `spinning_friction_rate` while the ball is on the cloth. It
  affects the motion only at impacts.

A ball may have friction coefficients of its own. With `air_drag` or `rolling_friction_quadratic`
the deceleration grows with the speed, and the curves aren't parabolas (`engine/motion/drag.py`).

Impacts
-------
Impacts take no time, unless `Physics.impacts` is "compliant". `Physics.ball_impact` and
`Physics.cushion` select the impact laws (`ghostball/model/impact_laws.py` lists them). Laws that
change spin need `motion` = "sliding".

`Physics.impacts` decides how simultaneous impacts that share a ball are resolved:

- "simultaneous": together, independently of the order of the balls, with Coulomb friction whatever
  `ball_impact` is.
- "sequential": one after another, the fastest first.
- "compliant": impacts last, and balls that push each other at the same time are integrated together
  (`engine/impacts/compliant.py`).

A ball that hits both cushions of a corner at once bounces off both together. If a ball hits a
cushion and another ball at the same time, the cushion is resolved first. Vertical impulses change
spin, but lift a ball only if `airborne` is true.

Flight
------
With `airborne` = true, balls may start above the cloth or be lifted by an impact. They fly along
parabolas (`engine/motion/flight.py`), or along curves in air (`engine/motion/flight_in_air.py`).
They bounce with `table_restitution`, and may fly over a cushion and leave the table. Contacts are
those of spheres in space; a cushion acts at its nose, `cushion_height` above the cloth. Impacts use
the scene's restitution and friction instead of the named laws, unless they are too slow to lift a
ball (`engine/impacts/in_space.py`).

Resting contact
---------------
Balls that friction presses together would bounce endlessly. Contact forces hold them together
instead, in steps that keep every gap within a tolerance (`engine/resting_contact/step.py`).
`Result.work["contact_steps"]` counts these steps.
"""

import lazy_loader

if not __name__.startswith("ghostball."):  # a second package with other classes
    raise ImportError(
        f"this package is part of ghostball: import `ghostball.{__name__}`, or "
        "`from ghostball import Scene, simulate`"
    )

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
