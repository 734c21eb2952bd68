"""Certificates on non-rectangular tables, compared with closed forms and Ghostball's engine."""

from __future__ import annotations

import numpy as np
import pytest
from proofs import ELL, met, proved
from right_shots import broken
from shots import ball, scene_of
from side_pocket import SIDE_POCKET, into_side_pocket

from ghostball.engine import simulate
from ghostball.model import Scene, Table
from ghostball.reference_adapters.certified import CertifiedSettings, certify
from ghostball.reference_adapters.certified.arithmetic import working_precision
from ghostball.reference_adapters.certified.obstacles import RoundPiece, obstacles_met
from ghostball.reference_adapters.certified.problem import problem_of
from ghostball.validation.scenes.random_scenes import PROVABLE, random_scene
from ghostball.validation.truth.scene_truth import truth_of


@pytest.mark.parametrize(("degrees", "goes"), [(68.2915, True), (68.2925, False)])
def test_the_critical_angle_of_a_side_pocket_is_proved(degrees: float, goes: bool):
    """Alciatore, technical proof 3.5: the largest angle is 68.292 degrees, for mirror cushions."""
    ends = []
    for aim in np.linspace(0.01294, 0.01300, 31):
        shot = into_side_pocket(degrees, float(aim), away=0.9, t_max=1.5)
        ends.append("pocketed bottom" in met(proved(shot)))
    assert any(ends) == goes


U = [[0, 0], [3, 0], [3, 2], [2, 2], [2, 1], [1, 1], [1, 2], [0, 2]]
SPIKE = [[0, 0], [3, 0], [3, 2], [1.6, 2], [1.5, 0.4], [1.4, 2], [0, 2]]


@pytest.mark.parametrize("vertices", [U, SPIKE], ids=["U", "spike"])
@pytest.mark.parametrize("velocity", [(2.0, 1.1), (1.3, -2.4), (-1.7, 2.2), (-0.6, -3.0)])
def test_a_ball_that_is_behind_a_side_is_not_in_it(vertices, velocity):
    """In one arm of a U, a ball is behind the inner side of the other arm, level with this side."""
    scene = scene_of(
        ball((2.5, 1.6), velocity),
        table=Table.model_validate({"vertices": vertices}),
        motion="sliding",
        cushion="han2005",
    )
    played = simulate(scene, record="events").events
    assert played is not None
    for bits in (53, 106):
        settings = CertifiedSettings(start_precision=bits)
        certificate = certify(scene, settings, cached=False)
        known = [event.key for event in certificate.events]
        assert len(known) > 5
        assert known == [(int(e["kind"]), int(e["a"]), int(e["b"])) for e in played][: len(known)]


def test_only_ends_that_a_ball_can_meet_are_points():
    """The corner of an L can be hit, but not the start of a jaw, or a corner of a rectangle."""
    with working_precision(53):
        for table, count in (({"vertices": ELL}, 1), ("wpa-9ft", 0), (SIDE_POCKET, 0)):
            scene = Scene.model_validate(
                {"name": "one", "table": table, "balls": [{"id": "a", "position": (0.5, 0.5)}]}
            )
            pieces = obstacles_met(problem_of(scene))
            points = [
                piece
                for piece in pieces
                if isinstance(piece, RoundPiece) and piece.radius.is_zero()
            ]
            assert len(points) == count
            assert len({piece.row for piece in pieces}) == len(pieces)


def test_a_ball_between_two_rails_in_one_line_is_in_contact_with_both_and_meets_one():
    """After a bounce off half of the bottom cushion, the line of the other half is equally near."""
    scene = scene_of(
        ball((2.0, 0.3), (1.0, -1.0)), table=Table.model_validate("wpa-9ft"), t_max=0.5
    )
    assert met(proved(scene)) == ["ball-cushion bottom"]


@pytest.mark.parametrize("kind", ["polygon", "pockets", "posts"])
@pytest.mark.parametrize("seed", range(3))
def test_our_engine_agrees_with_the_certificate(kind: str, seed: int):
    scene = random_scene(seed, **{**PROVABLE, "table": kind})
    assert broken(simulate(scene, record="trajectory"), truth=truth_of(scene)) == []
