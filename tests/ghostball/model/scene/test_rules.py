"""Rules about several parts of a scene: a scene that breaks each rule, and a change that fixes it.

Snapshots contain the messages, which name field, rule, value and remedy. The fixed scene must be
accepted, so a rule that refuses too much fails, too.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from refusals import loading, refusal
from shots import POOL_TABLE, R, ball, rack, scene_of

from ghostball.model import CUSHIONS, Table
from ghostball.model.impact_laws import BALL_LAWS
from ghostball.model.rounding import FLIGHT_CONTACT_TOLERANCE
from ghostball.model.scene.rules import overlaps

SLIDES = {"motion": "sliding"}
FLIES = {"motion": "sliding", "airborne": True}
ON_TABLE = {"table": POOL_TABLE}
OPEN = {"table": Table(length=2, width=2, cushions=())}

Balls = tuple[dict[str, Any], ...]
Rule = tuple[Balls, dict[str, Any], Balls | dict[str, Any]]
"""Balls and fields of a refused scene, and balls or fields with which it is accepted."""


def rule(*balls: dict[str, Any], mend: Balls | dict[str, Any], **fields: Any) -> Rule:
    return balls, fields, mend


# With the motion "rolling", the velocity determines the spin: no impact may change it.
MIDDLE, PAIR = ball((1, 1)), (ball((0, 0)), ball((1, 0)))
IMPACTS = {
    **{
        f"cushion {law} of balls that never slide": rule(
            MIDDLE, **ON_TABLE, cushion=law, mend=SLIDES
        )
        for law in ("frictional", "han2005", "mathavan2010", "stronge2000")
    },
    **{
        f"{field} {value} of balls that never slide": rule(*PAIR, **{field: value}, mend=SLIDES)
        for field, value in (
            ("ball_friction", 0.05),
            ("ball_friction", "alciatore"),
            ("ball_impact", "mathavan2014"),
        )
    },
    "a preset whose balls never slide": rule(
        MIDDLE,
        ball((0.5, 0.5)),
        **ON_TABLE,
        preset="pool",
        motion="rolling",
        mend={"cushion": "restitution", "ball_friction": 0.0},
    ),
}


def with_cushion(law: str, height: float, *radii: float, mend: Any) -> Rule:
    balls = [ball((0.3 + 0.4 * i, 0.6), radius=radius) for i, radius in enumerate(radii)]
    fields = {**ON_TABLE, **SLIDES, "cushion": law, "cushion_height": height}
    return rule(*balls, **fields, mend=mend)


# At the top, the contact normal is vertical: the cushion wouldn't reflect the ball.
JUST_BELOW = {"cushion_height": math.nextafter(2.0, 0.0) * R}
HEIGHTS = {
    f"{name} with {law}": with_cushion(law, height, *radii, mend=mend)
    for law in ("han2005", "mathavan2010", "stronge2000")
    for name, height, radii, mend in (
        ("a nose above a ball", 0.05, (R, 0.02, 0.03), {"cushion_height": 0.039}),
        ("a nose at the top of a ball", 2 * R, (R,), JUST_BELOW),
        ("a nose lost in rounding", 1e-20, (R,), {"cushion_height": 1e-3}),
    )
}
HEIGHTS["a nose above a ball on an open table"] = with_cushion("han2005", 0.05, 0.01, mend=OPEN)
HEIGHTS["a nose above a ball that may fly"] = rule(
    ball((1, 0.5)), **ON_TABLE, cushion_height=0.08, **FLIES, mend={"cushion_height": 0.03}
)

MATHAVAN = {**SLIDES, "ball_impact": "mathavan2014"}
LIMITS = {
    f"{field} beyond what mathavan2014 takes": rule(
        *PAIR, **MATHAVAN, **{field: math.nextafter(most, 2.0)}, mend={field: most}
    )
    for field, most in BALL_LAWS[1].limits
}
LIMITS["a ball's own friction beyond what mathavan2014 takes"] = rule(
    ball((0, 0), sliding_friction=0.2),
    ball((1, 0), sliding_friction=0.8),
    **MATHAVAN,
    mend=(ball((0, 0), sliding_friction=0.7), ball((1, 0), sliding_friction=0.2)),
)

# Decelerations that grow with speed: powers of a too high speed overflow.
DRAG = {
    f"{field} at {speed:g} m/s": rule(
        ball((0, 0), (speed, 0.0)), **{field: 1.1e10 / speed}, mend={field: 0.9e10 / speed}
    )
    for field in ("air_drag", "rolling_friction_quadratic")
    for speed in (1e-20, 1.0, 1e6)
}
DRAG["air_drag of a fall"] = rule(
    ball((0, 0)), **FLIES, gravity=10.0, air_drag=1.1e5, mend={"air_drag": 0.9e5}
)
DRAG["air_drag of a ball that could fall"] = rule(
    ball((0, 0)), **FLIES, gravity=10.0, air_drag=1.1e5, mend={"airborne": False}
)

# `t_max` is required if a ball might move forever, because any ball may set any other one in
# motion.
ENDS_LATER = {"t_max": 1.0}
MOVES, STILL = ball((0, 0), (1, 0)), ball((1, 0))
TURNS = ball((0, 0), angular_velocity=(0, 5, 0))
FAST = ball((0.5, 0.5), (0.0, 1e8))
ENDLESS = {
    **{
        f"a ball without friction beside one that moves, {motion}": rule(
            ball((0, 0), rolling_friction=0.0), ball((1, 0), (1, 0)), motion=motion, mend=ENDS_LATER
        )
        for motion in ("rolling", "sliding")
    },
    "a ball at rest without friction beside one with its own": rule(
        ball((0, 0), (1, 0), rolling_friction=0.01),
        STILL,
        rolling_friction=0.0,
        mend=(ball((0, 0), (1, 0), rolling_friction=0.01),),
    ),
    "a cloth on which a ball that is hit slides for ever": rule(
        MOVES, STILL, sliding_friction=0.0, **SLIDES, mend={"motion": "rolling"}
    ),
    **{
        f"a ball that turns about a level axis without {field}": rule(
            TURNS, **{field: 0.0}, **SLIDES, mend={field: 0.1}
        )
        for field in ("rolling_friction", "sliding_friction")
    },
    **{
        f"longer than doubles can follow: {field}, {start}": rule(
            ball((0, 0), velocity, angular_velocity=spin),
            ball((1, 0), **{field: 1e-42}),
            **SLIDES,
            mend=ENDS_LATER,
        )
        for field in ("rolling_friction", "sliding_friction")
        for start, velocity, spin in (
            ("rolling", (1e10, 0), None),
            ("turning", (0, 0), (1e12, 0, 0)),
            ("stunned", (1e10, 0), (0, 0, 0)),
        )
    },
    "more impacts than anyone waits for": rule(MIDDLE, FAST, **ON_TABLE, mend=ENDS_LATER),
    "impacts at an incredible speed": rule(
        MIDDLE, ball((0.5, 0.5), (0.0, 1e30)), **ON_TABLE, mend={"preset": "pool"}
    ),
    # Each metre costs the energy m mu g, and paths between impacts are at most 2.84 m long.
    "the most impacts of a ball alone": rule(
        ball((0.5, 0.5), (0.0, 1.06e6), mass=1.0),
        **ON_TABLE,
        mend=(ball((0.5, 0.5), (0.0, 1.06e6), mass=1.0), ball((1.0, 1.0), mass=2.0)),
    ),
    # mu g rounds to 0, as if there were no friction.
    **{
        f"{field} that rounds to nothing": rule(
            ball((0, 0), (1e-300, 0), **{field: 1e-300}), gravity=1e-50, **SLIDES, mend=ENDS_LATER
        )
        for field in ("rolling_friction", "sliding_friction")
    },
    "a table that returns all": rule(
        ball((0, 0), (0, 0, 1)), **FLIES, table_restitution=1.0, mend=ENDS_LATER
    ),
}


def turning(axis: int, radius: float) -> dict[str, Any]:
    spin = [0.0, 0.0, 0.0]
    spin[axis] = -2e30
    return ball((0, 0), radius=radius, angular_velocity=tuple(spin))


SMALL = ball((1e30, 1e30), (0, -1e50), radius=1e-50, angular_velocity=(1e50, 0, 1e50))
MOTION = {
    "a spin that is not that of rolling": rule(
        ball((0, 0), (1.0, 0.0), angular_velocity=(0.0, 30.0, 0.0)), mend=SLIDES
    ),
    # Warnings are errors here: an overflow in a rule would fail these.
    **{
        f"a surface that is too fast, about axis {axis}": rule(
            turning(axis, 1e20), **SLIDES, t_max=1.0, mend=(turning(axis, 1e19),)
        )
        for axis in range(3)
    },
    "a place that is not known to a radius": rule(
        SMALL, **SLIDES, t_max=1.0, mend=(SMALL | {"position": (0, 0)},)
    ),
    "a small ball that rolls for ever": rule(
        SMALL | {"position": (0, 0)}, **SLIDES, rolling_friction=1e-30, mend=ENDS_LATER
    ),
}

DEEP = 0.99 * FLIGHT_CONTACT_TOLERANCE * 2.0 * R
"""Largest overlap of an airborne ball with another ball, as in our engine [m]."""

ON_NOSE = 0.0357 + R
BELOW = ball((0, 0))
PLACES = {
    "two balls of one name": rule(
        ball((0, 0), id="cue"), STILL, ball((2, 0), id="cue"), mend=(STILL,)
    ),
    "an overlap": rule(
        ball((0, 0), id="cue"), STILL, ball((0.05, 0), id="eight"), mend=(BELOW, ball((2 * R, 0)))
    ),
    # In space the centres are farther apart than in the plane, as their heights differ.
    "an overlap of unequal balls": rule(
        ball((0, 0), radius=0.25),
        ball((0.74, 0), radius=0.5),
        mend=(ball((0, 0), radius=0.25), ball((0.75, 0), radius=0.5)),
    ),
    "the worst overlap of two": rule(BELOW, ball((0.1, 0)), ball((0.06, 0)), mend=PAIR),
    **{
        f"beyond the {cushion} cushion at {place}": rule(
            ball((1, 0.3)), ball(place, id="lost"), **ON_TABLE, mend={"table": None}
        )
        for cushion, place in (
            ("left", (0.02, 0.6)),
            ("right", (2.53, 0.6)),
            ("bottom", (1.0, 0.0)),
            ("top", (1.0, 1.3)),
            # Slightly more than rounding, and far more.
            ("left", (R - 1e-9, 0.6)),
            ("right", (2.54 - R + 1e-9, 0.6)),
            ("bottom", (1.0, R - 1e-9)),
            ("top", (1.0, 1.27 - R + 1e-9)),
            ("right", (1e6, 0.6)),
            ("bottom", (1.0, -1e6)),
        )
    },
    "a ball in the air": rule(ball((0, 0, 0.1)), mend=FLIES),
    "a ball that goes up": rule(ball((0, 0), (0, 0, 1)), mend=FLIES),
    "a ball in the cloth": rule(ball((0, 0, R - 1e-3)), **FLIES, mend=(BELOW,)),
    "a ball into the cloth": rule(
        ball((0, 0), (0, 0, -1e-9)), **FLIES, mend=(ball((0, 0, 1.1 * R), (0, 0, -1)),)
    ),
    # Above a cushion a ball may be nearer to it; on the cloth, at sqrt(h (2 R - h)).
    "in a cushion": rule(
        ball((1e-3, 0.5, 0.99 * ON_NOSE)), **FLIES, **ON_TABLE, mend=(ball((1e-3, 0.5, ON_NOSE)),)
    ),
    "outside above a cushion": rule(
        ball((-1e-3, 0.5, 2 * ON_NOSE)), **FLIES, **ON_TABLE, mend=(ball((1e-3, 0.5, 2 * ON_NOSE)),)
    ),
    "under a nose": rule(ball((0.96 * R, 0.5)), **FLIES, **ON_TABLE, mend=(ball((0.97 * R, 0.5)),)),
    "in a ball in the air": rule(
        BELOW, ball((0, 0, 2.5 * R)), **FLIES, mend=(BELOW, ball((0, 0, 3.5 * R)))
    ),
    "deeper in a ball than contacts are": rule(
        BELOW,
        ball((0, 0, 3.0 * R - 1.1 * DEEP)),
        **FLIES,
        mend=(BELOW, ball((0, 0, 3.0 * R - DEEP))),
    ),
    "as deep beside a ball": rule(BELOW, ball((2.0 * R - DEEP, 0)), **FLIES, mend=PAIR),
    "as deep on a cloth": rule(BELOW, ball((2.0 * R - DEEP, 0)), mend=PAIR),
    # Two balls at one position would count as touching there.
    **{
        f"where rounding is larger than a ball, at {place}": rule(BELOW, ball(place), mend=PAIR)
        for place in ((1e14, 0), (0, -1e14))
    },
    "two balls in one far place": rule(ball((1e12, 0)), ball((1e12, 0)), mend=PAIR),
}

RULES = IMPACTS | HEIGHTS | LIMITS | DRAG | ENDLESS | MOTION | PLACES


@pytest.mark.parametrize("name", RULES)
def test_what_breaks_a_rule_is_refused_and_what_mends_it_is_not(name, snapshot):
    balls, fields, mend = RULES[name]
    assert refusal(*balls, **fields) == snapshot
    if isinstance(mend, tuple):
        assert scene_of(*mend, **fields)
    else:
        assert scene_of(*balls, **fields | mend)


def test_in_a_file_the_line_is_that_of_the_law_or_else_of_the_physics():
    start = 'schema = 1\nname = "a"\n[physics]\nmotion = "rolling"\n'
    end = '[table]\nlength = 2\nwidth = 2\n[[balls]]\nid = "a"\nposition = [1, 1]\n'
    assert loading(start + 'cushion = "han2005"\n' + end).startswith("shot.toml:5: `motion`")
    assert loading(start + 'preset = "pool"\n' + end).startswith("shot.toml:3: `motion`")


def without(name: str) -> Table:
    return Table(length=2, width=2, cushions=tuple(one for one in CUSHIONS if one != name))


ACCEPTED = {
    **{
        f"{law} without a cushion, {kind}": ((MIDDLE,), {"table": table, "cushion": law})
        for law in ("frictional", "han2005", "mathavan2010", "stronge2000")
        for kind, table in (("no table", None), ("open", OPEN["table"]))
    },
    "friction of a ball alone": ((MIDDLE,), {"ball_friction": 0.05}),
    "a law of a ball alone": ((MIDDLE,), {"ball_impact": "mathavan2014"}),
    "a high nose without a table": (
        (ball((0, 0), radius=0.01),),
        {**SLIDES, "cushion": "han2005", "cushion_height": 0.05},
    ),
    "a spin of rolling": ((ball((0, 0), (1, 0), angular_velocity=(0, 1 / R, 0)),), {}),
    # The run doesn't wait for this spin, which moves no ball.
    "a spin about the vertical for ever": (
        (ball((0, 0), angular_velocity=(0, 0, 5)),),
        {"rolling_friction": 0, "sliding_friction": 0, "spinning_friction_rate": 0, **SLIDES},
    ),
    **{
        f"impacts that are fewer: {[*fewer]}": ((MIDDLE, FAST), {**ON_TABLE, **fewer})
        for fewer in (
            {"table": Table(length=2.54, width=1.27, cushions=("left", "right"))},
            {"preset": "pool"},
            {"cushion": "restitution", "cushion_restitution": 0.9},
            {"rolling_friction_quadratic": 1e-30},
        )
    },
    "a million metres a second": ((ball((0.5, 0.5), (0.0, 1e6)),), ON_TABLE),
    "the largest values": (
        (ball((0, 0), (1e50, 0), radius=1e50, angular_velocity=(0.5, 0.5, 0.5)),),
        {**SLIDES, "t_max": 1e50},
    ),
    **{
        f"a touching rack computed from sqrt(3) at {apex}": (rack(15, apex, gap=0.0), {})
        for apex in ((0.0, 0.0), (1.905, 0.635), (17.3, -4.1))
    },
    **{
        f"beyond an open {name} side": ((ball(place),), {"table": without(name)})
        for name, place in zip(CUSHIONS, ((-9, 1), (9, 1), (1, -9), (1, 9)), strict=True)
    },
}


@pytest.mark.parametrize("name", ACCEPTED)
def test_what_no_rule_forbids_is_accepted(name):
    balls, fields = ACCEPTED[name]
    assert scene_of(*balls, **fields)


def test_every_overlap_is_found_and_no_other():
    """Compare with a search over all pairs of balls, in forty shots at once."""
    chance = np.random.default_rng(1)
    for count in (1, 2, 3, 8, 30):
        centres = chance.uniform(0.0, 1.0, (40, count, 2))
        radii = chance.uniform(0.01, 0.2, count)
        distance = np.linalg.norm(centres[:, :, None] - centres[:, None], axis=3)
        overlap = radii[:, None] + radii - distance
        found = overlaps(centres, radii)
        assert (
            sorted(list(pair[:3]) for pair in found)
            == np.argwhere(np.tril(overlap > 1e-12, -1)).tolist()
        )
        assert [pair[:2] for pair in found] == sorted(pair[:2] for pair in found)
