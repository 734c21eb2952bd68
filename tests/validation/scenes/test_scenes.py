import itertools
import math
import shlex
from collections import Counter

import pytest
from random_layouts import FEW, has, options_in, touching_rails
from typer.main import get_command

from ghostball.cli import app
from ghostball.model import POOL_BALL_RADIUS as R
from ghostball.model.features import Feature, scene_features
from ghostball.validation.scenes import commands
from ghostball.validation.scenes.gases import FRICTIONLESS, packed_gas
from ghostball.validation.scenes.random_scenes import random_scene

# The commands in reports can be executed


ODD = "newcomer:name=a b;rm,dt=1e-3"


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (commands.simulate("stop"), ["run", "stop"]),
        (
            commands.simulate("my shot", ODD, recorded=True),
            [
                *("run", "./my shot.toml", "--engine", ODD),
                *("--record", "events", "--format", "json"),
            ],
        ),
        (commands.explain("stop", ODD), ["explain", "stop", "--engine", ODD]),
        (
            commands.validate("mine", "pymunk", "out/again"),
            ["validate", "./mine.toml", "--engine", "pymunk", "--out", "out/again"],
        ),
        (commands.regress(), ["regress"]),
        (commands.regress("stop", ODD), ["regress", "stop", "--engine", ODD]),
        (commands.regress("mine"), ["regress", "./mine.toml"]),
    ],
)
def test_a_shell_reads_a_command_as_it_was_meant(command, words):
    program, *arguments = shlex.split(command)
    assert program == "ghostball"
    assert arguments == words
    # The command line has the command and its options.
    subcommand = get_command(app).commands[words[0]]
    subcommand.make_context(words[0], words[1:])


# Gases have the requested packing


@pytest.mark.parametrize(("count", "packing"), [(1, 0.75), (7, 0.1), (16, 0.6)])
def test_a_packed_gas_has_its_packing(count, packing):
    scene = packed_gas(count, packing, FRICTIONLESS, t_max=1.0)
    columns = math.ceil(math.sqrt(count))
    places = columns * math.ceil(count / columns)
    covered = places * math.pi * R**2 / (scene.table.length * scene.table.width)
    assert covered == pytest.approx(packing)
    assert len(scene.balls) == count


# Random scenes have the features of their options, and no others


@pytest.mark.parametrize("preset", ["carom", "snooker"])
def test_a_preset_that_is_asked_for_brings_no_features_of_its_own(preset):
    for number in FEW:
        scene = random_scene(number, preset=preset, count="few")
        expected = tuple(one for one in Feature if has(one, options_in(scene)))
        assert scene_features(scene) == expected, scene.name
        assert scene.physics.preset == preset


# The positions of balls in random scenes follow the options, with gaps of any size


def test_gaps_of_loose_racks_are_of_any_size():
    gaps = []
    for number in range(100):
        scene = random_scene(number, layout="loose-rack", radii="equal", flight="no", count="many")
        pairs = itertools.combinations(scene.balls, 2)
        gaps.append(min(math.dist(a.position, b.position) - a.radius - b.radius for a, b in pairs))
    assert sum(gap < 1e-6 for gap in gaps) > 20
    assert sum(gap > 1e-4 for gap in gaps) > 20
    assert min(gaps) > 1e-10


def touching_balls(scene):
    """Return the number of touching pairs of balls."""
    return sum(
        abs(math.dist(one.position, other.position) - one.radius - other.radius) < 1e-13
        or (
            not scene.physics.airborne
            and abs(math.dist(one.position[:2], other.position[:2]) - one.radius - other.radius)
            < 1e-13
        )
        for one, other in itertools.combinations(scene.balls, 2)
    )


def test_balls_lie_as_their_options_say(few):
    """The balls of nearly all scenes; without room, balls lie elsewhere."""
    found = Counter()
    for scene in few:
        options = options_in(scene)
        rails, pairs = touching_rails(scene), touching_balls(scene)
        along = [
            ball
            for ball, touches in zip(scene.balls, rails, strict=True)
            if (touches[:2].any() and ball.velocity[0] == 0.0 != ball.velocity[1])
            or (touches[2:].any() and ball.velocity[1] == 0.0 != ball.velocity[0])
        ]
        facts = {
            ("layout", "touching"): pairs > 0,
            ("layout", "rack"): pairs > 2,
            ("layout", "rack-at-rail"): pairs > 2 and rails.any(axis=1).sum() > 1,
            ("layout", "rail"): rails.any(),
            ("layout", "corner"): (rails[:, :2].any(axis=1) & rails[:, 2:].any(axis=1)).any(),
            ("along-rail", "yes"): len(along) > 0,
            ("flight", "jump"): any(ball.velocity[2] > 0.0 for ball in scene.balls),
            ("flight", "drop"): any(ball.position[2] > ball.radius for ball in scene.balls),
            ("flight", "on-top"): any(ball.position[2] > ball.radius for ball in scene.balls),
            ("stop", "t-max"): scene.t_max is not None,
        }
        for option, fact in facts.items():
            if options[option[0]] == option[1]:
                found[option, bool(fact)] += 1
    for option, _ in list(found):
        right, wrong = found[option, True], found[option, False]
        assert right >= 9 * wrong, (option, right, wrong)
