"""The coefficient of friction between balls, constant or falling with the slip speed."""

from __future__ import annotations

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Laws

# Alciatore's fit to Marlow's measurements of throw (proof A.14).
_LEAST = 9.951e-3
_RANGE = 0.108
_DECAY = 1.088  # [s/m]

_NOTHING = 40.0
"""Argument above which the exponential is below half an ulp of the sum and is left out."""

_INVERSE_E = 0.36787944117144233

_INVERSE_FACTORIALS = (
    1.0 / 1307674368000.0,  # 15!
    1.0 / 87178291200.0,
    1.0 / 6227020800.0,
    1.0 / 479001600.0,
    1.0 / 39916800.0,
    1.0 / 3628800.0,
    1.0 / 362880.0,
    1.0 / 40320.0,
    1.0 / 5040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
    1.0 / 2.0,
    1.0,
    1.0,
)
"""Reciprocals of 15! down to 0!, the coefficients of the series. For arguments up to 1/2 the
truncation error of the series is 2e-17, and Horner's rule adds less than an ulp.
"""


@kernel
def friction_coefficient(laws: Laws, slip_speed: float) -> float:
    """Return the scene's coefficient of friction between balls at a slip speed [m/s]."""
    if laws.speed_dependent:
        return alciatore_friction(slip_speed)
    return laws.ball_friction


@kernel
def alciatore_friction(slip_speed: float) -> float:
    """Return the coefficient of friction between balls, 9.951e-3 + 0.108 exp(-1.088 v).

    `slip_speed` [m/s]: speed of one ball's surface over the other's just before the impact; not
    negative.

    Alciatore, technical proof A.14, a fit to data of Marlow. The exponential is computed with sums
    and products, because the last bit of a library's exponential depends on the machine: a factor
    1/e for each whole unit, and the power series for the rest, which is at most 1/2 in size. The
    rounding of the factors grows with their number n, but its effect on the sum falls as n exp(-n).
    The result is within 2 ulps of the exact sum.
    """
    argument = _DECAY * slip_speed
    if not argument < _NOTHING:
        return _LEAST
    factor = _RANGE
    while argument > 0.5:
        argument -= 1.0  # exact
        factor *= _INVERSE_E
    series = 0.0
    for coefficient in _INVERSE_FACTORIALS:
        series = coefficient - argument * series
    return _LEAST + factor * series
