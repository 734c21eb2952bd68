"""Adding a law takes a file, its entry in the registry and its branch in `dispatch`.

Broken by: a list of laws anywhere else, a law without its branch, a derivative that it must bring.
"""

import json
import os
import subprocess
import sys

import pytest
from ball_impacts import impact_of as balls_of, laws as ball_laws_of, shot
from copies import copy_packages
from cushion_impacts import impact_of as cushion_of, laws_of as cushion_laws_of
from kernels import entry_to

from ghostball.engine.impacts.laws.dispatch import ball_law, cushion_law
from ghostball.engine.impacts.laws.registry import BALL_LAW_NAMES, CUSHION_LAW_NAMES

CUSHION = '''"""A cushion that halves what comes along it, and gives side spin back reversed."""

from ghostball.engine.core.kernel import kernel
from ghostball.engine.impacts.laws.interface import CushionBounce


@kernel
def felt(impact, laws):
    vn = -laws.cushion_restitution * impact.vn
    return CushionBounce(vn, 0.5 * impact.vt, impact.wn, impact.wt, -impact.wz, 0.0)
'''
CUSHION_LINE = '    LawEntry("felt", ("cushion_restitution",), "made up"),\n'

CUSHION_BRANCH = """    if law == CUSHION_LAW_NAMES.index("felt"):
        return felt(impact, laws)
"""

BALL = '''"""Balls of putty: half of their approach is left over, and stays."""

from ghostball.engine.core.kernel import kernel
from ghostball.engine.impacts.laws.interface import BallImpulse


@kernel
def putty(impact, laws):
    return BallImpulse(impact.a_vn - impact.b_vn, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
'''
BALL_LINE = '    LawEntry("putty", (), "made up"),\n'
BALL_BRANCH = """    if laws.ball_law == BALL_LAW_NAMES.index("putty"):
        return putty(impact, laws)
"""

SHOT = """
import json
import numpy as np
from ghostball.engine import Ball, Physics, Scene, Table, simulate

fields = dict(preset="pool", motion="sliding", sliding_friction=0.0, rolling_friction=0.0,
              spinning_friction_rate=0.0, ball_friction=0.0)
ball = dict(radius=0.03, mass=0.17)
wall = simulate(
    Scene(
        name="wall",
        balls=(Ball(id="a", position=(1.0, 0.5), velocity=(1.0, 0.4),
                    angular_velocity=(0.0, 0.0, 7.0), **ball),),
        table=Table(length=2.0, width=1.0),
        physics=Physics(cushion="felt", cushion_restitution=0.5, **fields),
        t_max=1.2,
    ),
    record="trajectory",
)
pair = simulate(
    Scene(
        name="pair",
        balls=(Ball(id="a", position=(0.0, 0.0), velocity=(1.0, 0.0), **ball),
               Ball(id="b", position=(0.56, 0.0), **ball)),
        physics=Physics(ball_impact="putty", **fields),
        t_max=1.0,
    ),
    record="trajectory",
)
grown = [float(np.max(shot.sensitivity([1.0]))) for shot in (wall, pair)]
after = wall.sample([1.1])
print(json.dumps([after.velocities[0, 0].tolist(), after.angular_velocities[0, 0].tolist(),
                  pair.rest_positions.tolist(), grown]))
"""


@pytest.fixture
def copy(tmp_path):
    """A copy of the engine with both laws."""
    laws = copy_packages(tmp_path, "engine", bytecode=False) / "engine/impacts/laws"
    (laws / "cushion_felt.py").write_text(CUSHION)
    (laws / "ball_putty.py").write_text(BALL)
    balls, cushions = (laws / "registry.py").read_text().split("\nCUSHION_LAWS = (\n")
    balls = balls.removesuffix(")\n") + BALL_LINE + ")\n"
    cushions = cushions.replace("\n)\n", "\n" + CUSHION_LINE + ")\n", 1)
    (laws / "registry.py").write_text(balls + "\nCUSHION_LAWS = (\n" + cushions)
    calls = (laws / "dispatch.py").read_text()
    calls = calls.replace(
        "\nfrom ghostball.engine.impacts.laws.interface",
        "\nfrom ghostball.engine.impacts.laws.ball_putty import putty"
        "\nfrom ghostball.engine.impacts.laws.cushion_felt import felt"
        "\nfrom ghostball.engine.impacts.laws.interface",
        1,
    )
    for branch, last in (
        (BALL_BRANCH, "    return frictional_balls("),
        (CUSHION_BRANCH, "    return restitution("),
    ):
        assert calls.count(last) == 1
        calls = calls.replace(last, branch + last)
    (laws / "dispatch.py").write_text(calls)
    return tmp_path


def test_a_law_is_a_file_an_entry_and_a_branch(copy):
    done = subprocess.run(
        [sys.executable, "-c", SHOT],
        env={**os.environ, "PYTHONPATH": str(copy), "NUMBA_DISABLE_JIT": "1"},
        cwd=copy,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    velocity, spin, places, grown = json.loads(done.stdout)
    assert velocity[:2] == pytest.approx([-0.5, 0.2], abs=1e-12)
    assert spin[2] == pytest.approx(-7.0)
    # They touch at 0.5 s, and go on together at half the speed.
    assert [place[0] for place in places] == pytest.approx([0.75, 0.81])
    assert all(1.0 < growth < 100.0 for growth in grown)


def test_each_law_has_its_branch():
    # One without would silently bounce like the law that stands last in its chain.
    laws = ball_laws_of(0.9, 0.1)._replace(integrated=1)
    impact = balls_of(shot(0.5, 1.0, roll=-1.0, side=0.3))
    call = entry_to(ball_law)
    outcomes = {call(impact, laws._replace(ball_law=code)) for code in range(len(BALL_LAW_NAMES))}
    assert len(outcomes) == len(BALL_LAW_NAMES)

    laws = cushion_laws_of(e=0.9, tangential=0.8)._replace(integrated=1)
    impact = cushion_of(1.0, 0.7, 20.0, 5.0, 11.0)
    call = entry_to(cushion_law)
    outcomes = {call(impact, laws, code) for code in range(len(CUSHION_LAW_NAMES))}
    # A mirror is that law with both its factors 1.
    assert len(outcomes) == len(set(CUSHION_LAW_NAMES) - {"mirror"})
