"""Sines and cosines of arrays with identical bits on every machine: only + - * / are used.

The sines of system libraries, and of numpy, differ between machines in the last bit. The method,
the polynomials and the parts of pi / 2 are those of fdlibm (Sun Microsystems, 1993: `e_rem_pio2.c`,
`k_sin.c`, `k_cos.c`). The errors of fdlibm are below one unit in the last place.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_SINE = (
    -1.66666666666666324348e-01,
    8.33333333332248946124e-03,
    -1.98412698298579493134e-04,
    2.75573137070700676789e-06,
    -2.50507602534068634195e-08,
    1.58969099521155010221e-10,
)
_COSINE = (
    4.16666666666666019037e-02,
    -1.38888888888741095749e-03,
    2.48015872894767294178e-05,
    -2.75573143513906633035e-07,
    2.08757232129817482790e-09,
    -1.13596475577881948265e-11,
)

_QUARTER_TURN = (1.57079632673412561417e00, 6.07710050630396597660e-11, 2.02226624871116645580e-21)
"""The first 99 bits of pi / 2 in three parts of 33 bits: each times the number of quarter turns is
exact."""

_QUARTER_TURN_REST = 8.47842766036889956997e-32
"""pi / 2 minus these parts."""

_LARGEST_UNREDUCED = 2.0**19
"""Whole turns are removed first from angles beyond this size [rad]: the error of the removal is
smaller than the rounding of the angle."""


def cosines_and_sines(
    angles: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the cosines and the sines of finite angles [rad], in arrays of the same shape."""
    angles = np.where(np.abs(angles) < _LARGEST_UNREDUCED, angles, np.fmod(angles, 2.0 * np.pi))
    quarters = np.rint(angles / (0.5 * np.pi))
    rest, low = angles, quarters * _QUARTER_TURN_REST
    for part in _QUARTER_TURN:
        before, taken = rest, quarters * part
        rest = before - taken
        low = low - ((before - rest) - taken)
    x = rest - low
    low = (rest - x) - low

    z = x * x
    cube = z * x
    series = _polynomial(_SINE[1:], z)
    sine = x - ((z * (0.5 * low - cube * series) - low) - cube * _SINE[0])
    half = 0.5 * z
    near = 1.0 - half
    cosine = near + (((1.0 - near) - half) + (z * (z * _polynomial(_COSINE, z)) - x * low))

    turn = quarters.astype(np.int64) & 3
    cosines = np.choose(turn, (cosine, -sine, -cosine, sine))
    sines = np.choose(turn, (sine, cosine, -sine, -cosine))
    return cosines, sines


def _polynomial(coefficients: tuple[float, ...], z: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the value of a polynomial at z; the lowest coefficient comes first."""
    total = np.full_like(z, coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        total = coefficient + z * total
    return total
