"""Tests of the law that multiplies velocities; `test_cushion_han2005` tests the common contract."""

from cushion_impacts import cushions, impacts
from hypothesis import given
from kernels import entry_to

from ghostball.engine.impacts.laws.cushion_restitution import restitution

restitution = entry_to(restitution)


@given(impacts, cushions)
def test_restitution_multiplies_the_velocity_and_leaves_the_spin(impact, cushion):
    assert restitution(impact, cushion) == (
        -cushion.restitution * impact.vn,
        cushion.tangential * impact.vt,
        impact.wn,
        impact.wt,
        impact.wz,
        0.0,
    )
