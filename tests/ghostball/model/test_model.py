from __future__ import annotations

import json
import math
import pickle
import subprocess
import sys
from pathlib import Path

import mpmath
import numpy as np
import pytest
from shots import FLIES

from ghostball.engine import simulate
from ghostball.model import (
    EVENT_DTYPE,
    Ball,
    EngineFailedError,
    EventKind,
    GhostballError,
    Physics,
    Scene,
    SceneError,
    Status,
    Strike,
    UnsupportedSceneError,
)
from ghostball.model.cache_folder import CACHE_DIR_VARIABLE, cache_folder
from ghostball.model.hashes import bits_hash, sequence_hash
from ghostball.model.rounding import EPS, POSITION_ULPS, position_rounding
from ghostball.model.scene import stroke_of
from ghostball.model.sines import cosines_and_sines
from ghostball.model.strokes import struck_balls

# Each cache has a separate folder in the folder that the user chose


def test_all_caches_are_in_the_chosen_folder(monkeypatch, tmp_path):
    monkeypatch.setenv(CACHE_DIR_VARIABLE, str(tmp_path))
    assert cache_folder("proofs") == tmp_path / "proofs"
    assert not list(tmp_path.iterdir())  # a cache creates its folder on first use


def test_without_a_choice_they_are_in_the_systems_folder_for_us(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("HOME", str(tmp_path))
    for chosen in (None, ""):
        monkeypatch.delenv(CACHE_DIR_VARIABLE, raising=False)
        if chosen is not None:
            monkeypatch.setenv(CACHE_DIR_VARIABLE, chosen)
        folder = cache_folder("libraries")
        assert folder.name == "libraries"
        assert "ghostball" in folder.parent.parts[-1].lower()
        assert folder.is_relative_to(Path(tmp_path))


# Errors name the failed engine and the reason, and can be pickled


@pytest.mark.parametrize(
    "error",
    [
        UnsupportedSceneError("toy", ("no flight", "no spin")),
        EngineFailedError("toy", "it raised ValueError", "line 3"),
        SceneError("`mass` must be positive"),
    ],
)
def test_an_error_survives_pickling(error):
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), str(again), vars(again)) == (type(error), str(error), vars(error))
    assert isinstance(again, GhostballError)


def test_only_what_our_own_engine_raised_is_our_bug():
    assert EngineFailedError("ghostball", "it raised", "line 3").is_our_bug
    assert not EngineFailedError("ghostball", "it hung").is_our_bug
    assert not EngineFailedError("toy", "it raised", "line 3").is_our_bug


def test_what_no_file_takes_is_written_as_python_writes_it():
    failed = EngineFailedError("toy", "ValueError: \udcff", "line \ud800")
    refused = UnsupportedSceneError("toy", ("no \udcff", "é 🎱"))
    assert (failed.reason, failed.trace) == (r"ValueError: \udcff", r"line \ud800")
    assert refused.features == (r"no \udcff", "é 🎱")
    for one in (failed, refused):
        str(one).encode()


# Names of event kinds in files and reports, and statuses of complete runs


def test_kinds_have_the_names_of_files_and_reports():
    assert [kind.label for kind in EventKind] == [
        "ball-ball",
        "ball-cushion",
        "slide-to-roll",
        "roll-to-rest",
        "pocketed",
        "ball-cloth",
        "leaves-table",
    ]


def test_a_run_is_complete_where_all_balls_rest_or_its_time_is_over():
    assert [one for one in Status if one.complete] == [Status.REST, Status.T_MAX]


# Hashes: each bit counts, and hashes are the same on every platform and in every version


EVENTS = np.array(
    [(0.25, EventKind.BALL_BALL, 0, 1), (0.5, EventKind.ROLL_TO_REST, 1, -1)], dtype=EVENT_DTYPE
)
PLACES = np.array([[0.5, 0.25, 0.0], [1.0, 2.0, 0.0]])


def test_the_hashes_are_what_they_were():
    # If the definition of a hash changes, every baseline reports changed results.
    assert bits_hash(EVENTS, PLACES) == (
        "35b65969dcbe6aa4a10842730bf38e99714b46ff44a429a53eb9648556b625e1"
    )
    assert sequence_hash(EVENTS) == (
        "1be9a5b603bc4529a804e122ff7c0805e002c04bc4e6da46bc277449e29cbea8"
    )


def test_only_0_and_minus_0_are_one_place():
    assert bits_hash(EVENTS, PLACES * np.array([1.0, 1.0, -1.0])) == bits_hash(EVENTS, PLACES)
    moved = PLACES.copy()
    moved[1, 1] = np.nextafter(2.0, 3.0)
    assert bits_hash(EVENTS, moved) != bits_hash(EVENTS, PLACES)


def test_places_in_another_layout_of_memory_are_the_same_places():
    assert bits_hash(EVENTS, np.asfortranarray(PLACES)) == bits_hash(EVENTS, PLACES)
    padded = np.dtype([("b", "<i4"), ("t", "<f8"), ("kind", "<i8"), ("a", "<i4")])
    other = np.empty(2, dtype=padded)
    for name in padded.names:
        other[name] = EVENTS[name]
    assert bits_hash(other, PLACES) == bits_hash(EVENTS, PLACES)
    assert sequence_hash(other) == sequence_hash(EVENTS)


@pytest.mark.parametrize("column", EVENT_DTYPE.names)
def test_every_column_counts_and_the_order_of_events_has_no_instants(column):
    other = EVENTS.copy()
    other[column][0] = np.nextafter(0.25, 1.0) if column == "t" else 3
    assert bits_hash(other, PLACES) != bits_hash(EVENTS, PLACES)
    assert (sequence_hash(other) == sequence_hash(EVENTS)) == (column == "t")


def test_two_events_that_swap_places_have_another_hash():
    assert sequence_hash(EVENTS[::-1]) != sequence_hash(EVENTS)


# The list of the laws of impacts


@pytest.mark.parametrize(
    ("imported", "without"),
    [
        ("ghostball.engine.capabilities", ["ghostball.engine.core"]),
        (
            "ghostball.engine.shot",
            ["numba", "filelock", "ghostball.engine.sensitivity"],
        ),
    ],
)
def test_knowing_the_laws_and_importing_the_engine_need_little(imported, without):
    # Fails if a module imports at its top a package that few shots need, or only compilation.
    check = f"import sys, {imported}; print([m for m in {without} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


# Permitted rounding of given positions: more than that of sums of roots, far less than a ball


def test_position_rounding_is_proportional_to_the_sum_of_sizes():
    assert position_rounding(1.0, -2.0) == 3.0 * POSITION_ULPS * EPS
    found = position_rounding(np.array([1.0, -4.0]), np.array([2.0, 0.0]))
    assert found.tolist() == [position_rounding(1.0, 2.0), position_rounding(4.0)]


@pytest.mark.parametrize("radius", [0.028575, 0.02625, 1.0 / 3.0])
def test_a_row_of_balls_that_touch_by_computed_places_is_within_it(radius):
    step, x, y = 2.0 * radius, 0.1, 0.1
    for k in range(1, 40):
        next_x, next_y = 0.1 + k * step * math.sqrt(0.75), 0.1 + 0.5 * k * step
        overlap = abs(math.hypot(next_x - x, next_y - y) - step)
        assert overlap <= position_rounding(next_x, next_y)
        x, y = next_x, next_y


# Portable sines and cosines agree with values of many digits


def test_sines_and_cosines_are_right_within_one_ulp():
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


def test_sines_and_cosines_have_the_same_bits_on_every_machine():
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


# The description of the strokes of a scene


STRIKE = Strike(speed=3.0, direction=2.5, elevation=0.2, offset_left=0.3, squirt="alciatore")
SCENE = Scene(
    name="a",
    physics=Physics(**FLIES),
    balls=[
        Ball(id="still", position=(1.0, 1.0)),
        Ball(id="cue", position=(0.0, 0.0), strike=STRIKE),
    ],
)


def test_each_ball_that_is_struck_is_told():
    (struck,) = struck_balls(SCENE)
    stroke = stroke_of(STRIKE, SCENE.balls[1].radius, SCENE.balls[1].mass)
    told = struck.to_dict()
    assert told == {
        "ball": 1,
        "strike": STRIKE.model_dump(),
        "tip_velocity": list(stroke.velocity),
        "squirt_angle": struck.squirt_angle,
        "cue_speed": stroke.cue_speed,
        "velocity": SCENE.velocities[1].tolist(),
        "angular_velocity": SCENE.angular_velocities[1].tolist(),
    }
    result = simulate(SCENE)
    assert json.loads(result.to_json())["strikes"] == [told]
    assert simulate(SCENE.without_strikes()).to_dict()["strikes"] == []


@pytest.mark.parametrize("direction", [0.0, 1.0, 2.5, -3.0])
def test_squirt_is_seen_from_above_and_away_from_the_side_that_is_hit(direction):
    strike = STRIKE.model_copy(update={"direction": direction})
    (struck,) = struck_balls(Scene(name="a", physics=SCENE.physics, balls=[ball_with(strike)]))
    ratio = struck.ball.mass / strike.end_mass
    behind = 1.0 - 0.3**2
    tangent = 2.5 * 0.3 * math.sqrt(behind) / (1.0 + ratio + 2.5 * behind)
    assert struck.squirt_angle == pytest.approx(-math.atan(tangent), rel=1e-12)


def ball_with(strike: Strike) -> Ball:
    return Ball(id="cue", position=(0.0, 0.0), strike=strike)
