"""Random shots for hypothesis: balls that only roll, and balls that slide and spin by all laws."""

from __future__ import annotations

import random

from hypothesis import strategies as st
from shots import POOL_TABLE, random_shot
from transforms import changed, with_balls

from ghostball.engine import Scene, Table

LAWS = st.fixed_dictionaries(
    {
        "rolling_friction": st.sampled_from([0.005, 0.02, 0.3]),
        "ball_restitution": st.sampled_from([1.0, 0.95, 0.5]),
    }
)
TABLES = st.sampled_from(
    [None, POOL_TABLE, Table(length=2.54, width=1.27, cushions=("left", "top"))]
)
NOSE = {"cushion_friction": 0.2, "cushion_height": 0.02}  # lower than the smallest ball
CUSHIONS = st.sampled_from(
    [
        {"cushion": "mirror"},
        {"cushion": "restitution", "cushion_restitution": 0.7},
        {"cushion": "frictional", "cushion_restitution": 0.85, "cushion_friction": 0.2},
        {"cushion": "han2005", "cushion_restitution": 0.85, **NOSE},
        {"cushion": "mathavan2010", "cushion_restitution": 0.98, **NOSE},
    ]
)


@st.composite
def sliding_laws(
    draw, frictions=(0.0, 0.06, "alciatore"), ball_laws=("frictional", "mathavan2014")
):
    """Return the physics of a game with spin: all laws of impacts and all frictions."""
    return {
        "motion": "sliding",
        "rolling_friction": draw(st.sampled_from([0.005, 0.02])),
        "sliding_friction": draw(st.sampled_from([0.15, 0.4])),
        "spinning_friction_rate": draw(st.sampled_from([5.0, 50.0])),
        "ball_impact": draw(st.sampled_from(ball_laws)),
        "ball_restitution": draw(st.sampled_from([1.0, 0.95, 0.5])),
        "ball_friction": draw(st.sampled_from(frictions)),
        "impacts": draw(st.sampled_from(["simultaneous", "sequential"])),
        **draw(CUSHIONS),
    }


def spun(scene: Scene, seed: int) -> Scene:
    """Return the scene with two of three balls spun at random, whether they move or not."""
    chance = random.Random(seed)
    return with_balls(
        scene,
        [
            changed(one, angular_velocity=[chance.uniform(-3.0, 3.0) / one.radius for _ in "xyz"])
            if chance.random() < 2 / 3
            else one
            for one in scene.balls
        ],
    )


@st.composite
def shots(draw, tables=TABLES, laws=LAWS, most=6):
    """Return a random shot: seed, count, table and physics are what hypothesis shrinks."""
    n = draw(st.integers(1, most))
    return random_shot(draw(st.integers(0, 10_000)), n, table=draw(tables), **draw(laws))


@st.composite
def sliding_shots(draw, tables=TABLES, laws=None, most=6):
    """Return a random shot with spin; hypothesis shrinks as in `shots`."""
    laws = sliding_laws() if laws is None else laws
    scene = draw(shots(tables=tables, laws=laws, most=most))
    return spun(scene, draw(st.integers(0, 10_000)))


def all_shots(tables=TABLES, most=6, **sliding):
    """Return shots of balls that only roll, and of balls that slide and spin."""
    laws = sliding_laws(**sliding)
    return st.one_of(
        shots(tables=tables, most=most), sliding_shots(tables=tables, laws=laws, most=most)
    )
