"""Tests of tangent maps against stored results of an earlier implementation in kernels."""

from __future__ import annotations

import math

import numpy as np
import pytest
from changes import directions_of, recorded

from ghostball.validation.scenes.library import find_scene

# Scene, horizon for 1 um at an error of 1e-9 [s], largest growth at the end [m], and sizes of the
# effects of a change: on positions [m] and velocities [m/s] at 0.7 of the time, and on event times
# [s].
KNOWN = (
    (
        "break-7",
        math.inf,
        249.48680725551102,
        43.22573728460212,
        5.310630416024078,
        102.32452795165521,
    ),
    (
        "chaos-a",
        0.77710437693313,
        5977383464605971.0,
        5144724966074.4795,
        13397403098998.055,
        51354216760101.586,
    ),
    (
        "coulomb-break-9",
        3.0394284754355856,
        2272.354580906072,
        35.79787277325965,
        0.24316525101804562,
        113.3288029255679,
    ),
    (
        "han-running",
        math.inf,
        5.4195954766979995,
        3.0510137828141985,
        1.2322383418725333,
        6.294464742207112,
    ),
    (
        "masse",
        math.inf,
        27.408306361971885,
        15.39720409965828,
        3.214772837719564,
        1.8047758578801594,
    ),
    (
        "mathavan-cut",
        math.inf,
        11.954571132,
        4.2148662246291275,
        0.7190362055867576,
        5.621980225058759,
    ),
    (
        "pool-break-9",
        1.0499208337905397,
        156657.4010271275,
        1612.799522361757,
        19.593991725497197,
        6429.60417399674,
    ),
    (
        "throw-alciatore",
        math.inf,
        4.316408343591734,
        6.696017154818456,
        2.8691634215468675,
        14.548175444356145,
    ),
    (
        "unequal-balls",
        math.inf,
        6.552595658531218,
        14.242081718341133,
        3.77005995302019,
        18.595959810445944,
    ),
    (
        "gas-80",
        0.20572868817380033,
        2637.0218283997565,
        42.613232227085234,
        808.8939733957862,
        145.65673730968837,
    ),
    (
        "polygon-sliding",
        math.inf,
        4.129203921160065,
        2.251757762181631,
        0.7028709205180573,
        4.419400676707054,
    ),
    (
        "pocket-two",
        math.inf,
        0.39187571768365304,
        0.46865502523660435,
        1.507403207360844,
        0.469943156333548,
    ),
)


JUST_BEFORE_THE_STOP = ("mathavan-cut",)
"""Scenes whose growth is read just before the last stop.

The growth at the stop includes the sampled rounding of the stop. Its size depends on the rounding
of the law of impacts in these scenes.
"""


@pytest.mark.parametrize(("name", *"hgxvs"), KNOWN)
def test_the_numbers_are_those_of_the_kernels(name, h, g, x, v, s):
    assert numbers_of(name) == pytest.approx((h, g, x, v, s), rel=1e-9)


def numbers_of(name):
    result = recorded(find_scene(name))
    tangent = result.tangent(directions_of(result.scene, 2))
    last = result.rest_time
    if name in JUST_BEFORE_THE_STOP:
        last = math.nextafter(last, 0.0)
    (sample,) = tangent.sample([0.7 * result.rest_time])
    return (
        result.horizon(1e-6, 1e-9),
        float(np.max(result.sensitivity([last]))),
        float(np.linalg.norm(sample[..., :2])),
        float(np.linalg.norm(sample[..., 2:4])),
        float(np.linalg.norm(tangent.event_shifts)),
    )
