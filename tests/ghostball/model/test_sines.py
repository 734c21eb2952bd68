"""Sines and cosines that are the same everywhere, against many digits."""

import mpmath
import numpy as np

from ghostball.model.sines import cosines_and_sines


def test_they_are_right_to_less_than_a_unit_in_the_last_place():
    chance = np.random.default_rng(5)
    angles = np.concatenate(
        (
            chance.uniform(-7.0, 7.0, 1_000),
            chance.uniform(-5e5, 5e5, 1_000),
            np.arange(-20, 21) * np.pi / 4.0,
            10.0 ** chance.uniform(-320.0, 0.0, 200),
            [0.0, 5e-324, 2.0**19 - 0.25],
        )
    )
    for exact, found in zip((mpmath.cos, mpmath.sin), cosines_and_sines(angles), strict=True):
        with mpmath.workprec(200):
            right = [exact(mpmath.mpf(float(angle))) for angle in angles]
            off = [float(mpmath.mpf(float(f)) - r) for f, r in zip(found, right, strict=True)]
        assert np.all(np.abs(off) < 0.85 * np.spacing(np.abs(found)))


def test_of_large_angles_they_are_right_to_the_rounding_of_the_angle():
    for angle in (1e6, -1e9, 1e15):
        cosine, sine = cosines_and_sines(np.array([angle]))
        with mpmath.workprec(200):
            off = mpmath.atan2(sine[0], cosine[0]) - mpmath.mpf(angle)
            off -= 2 * mpmath.pi * mpmath.nint(off / (2 * mpmath.pi))
        assert abs(float(off)) < 0.5 * np.spacing(abs(angle))


def test_they_are_the_bits_that_every_machine_gives():
    cosines, sines = cosines_and_sines(np.array([0.5, 2.0, 1e3, -3.7e5, 1e12]))
    assert [float(c).hex() for c in cosines] == [
        "0x1.c1528065b7d50p-1",
        "-0x1.aa22657537205p-2",
        "0x1.1ff026793f1bcp-1",
        "-0x1.e759e033b0ee6p-2",
        "0x1.953b929a5c982p-1",
    ]
    assert [float(s).hex() for s in sines] == [
        "0x1.eaee8744b05f0p-2",
        "0x1.d18f6ead1b446p-1",
        "0x1.a75cc150a206bp-1",
        "-0x1.c24bb40b7fef5p-1",
        "-0x1.38f03c3d68741p-1",
    ]
