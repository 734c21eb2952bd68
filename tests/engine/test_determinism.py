"""The same scene gives the same bits: compiled and interpreted, whatever ran before.

One hash per scene over the event log (t, kind, a, b) and the rest positions. `make test-nojit` asks
for the same ones without a compiler: a fused multiply-add or a reordered sum would show there. A
hash that changes means that numbers moved: say so in the changelog under "Results change", and
store the new one.
"""

from __future__ import annotations

import pytest
from invariants import fingerprint
from shots import POOL_TABLE, ball, rack, random_shot, scene_of

from ghostball.engine import Scene, Table, simulate


def paper_break() -> Scene:
    """A break of 8 off its line of symmetry, the paper's physics, a rack gap of 0.1 mm."""
    return scene_of(
        ball((0.6, 0.635), (4.0, 0.03125)), *rack(7, (1.9, 0.635), 1e-4), table=POOL_TABLE
    )


def lossy_break() -> Scene:
    """The same break with losses at balls and cushions, and unequal balls."""
    balls = [
        {**one, "mass": 0.17 + 0.001 * k, "radius": 0.028575 - 1e-5 * k}
        for k, one in enumerate(rack(7, (1.9, 0.635), 1e-4))
    ]
    return scene_of(
        ball((0.6, 0.635), (4.0, 0.03125)),
        *balls,
        table=POOL_TABLE,
        ball_restitution=0.95,
        cushion="restitution",
        cushion_restitution=0.85,
        cushion_tangential_restitution=0.9,
    )


def gas() -> Scene:
    """Six balls without friction on a small table, for 20 s."""
    return random_shot(6, 6, table=Table(length=0.8, width=0.6), rolling_friction=0.0, t_max=20.0)


def cloth_break() -> Scene:
    """A break of 8 with spin, throw and frictional cushions."""
    return scene_of(
        ball((0.6, 0.635), (4.0, 0.03125), angular_velocity=(20.0, -40.0, 30.0)),
        *rack(7, (1.9, 0.635), 1e-4),
        table=POOL_TABLE,
        motion="sliding",
        ball_restitution=0.95,
        ball_friction="alciatore",
        cushion="han2005",
        cushion_restitution=0.85,
    )


def integrated_laws() -> Scene:
    """Three balls with spin, by the laws that integrate over the impulse."""
    return scene_of(
        ball((0.5, 0.4), (2.0, 0.75), angular_velocity=(10.0, 50.0, -40.0)),
        ball((1.2, 0.68)),
        ball((1.6, 0.9), (-1.0, 0.5), angular_velocity=(5.0, 0.0, 25.0)),
        table=POOL_TABLE,
        motion="sliding",
        ball_impact="mathavan2014",
        ball_restitution=0.89,
        ball_friction=0.05,
        cushion="mathavan2010",
        cushion_restitution=0.98,
        cushion_friction=0.14,
    )


def frozen_pair() -> Scene:
    """Topspin drives a ball into two frozen ones: joint impacts, and contact steps."""
    return scene_of(
        ball((0.5, 0.635), (1.5, 0.0), angular_velocity=(0.0, 90.0, 10.0)),
        ball((1.0, 0.64)),
        ball((1.05715, 0.64)),
        table=POOL_TABLE,
        motion="sliding",
        ball_restitution=0.9,
        ball_friction=0.06,
        cushion="frictional",
        cushion_restitution=0.85,
    )


SCENES = {
    "paper-break": paper_break,
    "lossy-break": lossy_break,
    "gas": gas,
    "cloth-break": cloth_break,
    "integrated-laws": integrated_laws,
    "frozen-pair": frozen_pair,
}
STORED = {
    "paper-break": "a2b14b91e2795de62272e2ec6d69e57ab239436828813cb81e5d6a6734753f58",
    "lossy-break": "a8aefc019693c854bbd3fb3c3b531d72357e84276e49cdae8f6310fddcd718ba",
    "gas": "f8fec0e5a91609bcb68320748ab2945b23154a5c712c069581f289d85d87193e",
    "cloth-break": "0571098962c4f27fbf549f2bb062925845a3545394a9869d82f515230cd9a611",
    "integrated-laws": "d38a6456398fc1cc602a7f279998b3c0c711106995473197865d25ff596b4970",
    "frozen-pair": "0ab20f4137b3fd082b2037e811436644b7d4f6bdfd89e19a074583137a48b6d8",
}


@pytest.mark.parametrize("name", SCENES)
def test_the_stored_hash_holds(name):
    result = simulate(SCENES[name](), record="events")
    assert result.status.complete
    assert len(result.events) > 10  # enough to show a difference
    assert (result.work["contact_steps"] > 0) == (name == "frozen-pair")
    assert fingerprint(result) == STORED[name]


def test_what_ran_before_leaves_no_trace():
    simulate(gas(), record="trajectory")
    simulate(lossy_break(), max_events=7)
    assert fingerprint(simulate(paper_break(), record="events")) == STORED["paper-break"]
