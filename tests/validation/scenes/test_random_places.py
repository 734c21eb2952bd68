"""Where balls of random scenes lie: as their options say, with gaps of any size."""

import itertools
import math
from collections import Counter

from random_layouts import options_in, touching_rails

from ghostball.validation.scenes.random_scenes import (
    random_scene,
)


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
    """Return how many pairs of balls touch."""
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
    """Nearly always: where there is no room they lie elsewhere."""
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
