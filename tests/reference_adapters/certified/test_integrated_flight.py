"""Shots in flight against an integration by scipy, with laws of impacts written anew."""

from __future__ import annotations

import numpy as np
import pytest

from ghostball.engine import EventKind, simulate
from ghostball.reference_adapters.certified import CertifiedSettings, certify
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.stress.random_jumps import random_jump

SHIPPED = ("flight-bounces", "flight-jump", "flight-leaves", "flight-throw")

FEW = [
    *(0, 2, 3, 6, 7, 9, 10, 11, 17, 19, 20, 21, 22, 25, 27, 28, 32),
    *(33, 38, 39, 40, 41, 44, 48, 49, 50, 51, 53, 54, 62, 64, 65, 67, 68),
]
"""The random jumps before the 70th that have up to four balls."""

ROOM = 1e-10
"""In s and m: the integrator errs by 1e-13 of the state in a step, which the shots amplify."""


Event = tuple[float, int, int, int]


def by_ball(events: list[Event], n: int) -> list[list[Event]]:
    """Return what happens to each ball: events of others at one instant have no order."""
    both = int(EventKind.BALL_BALL)
    return [[e for e in events if k == e[2] or (e[1] == both and k == e[3])] for k in range(n)]


def check_same(some: list[Event], others: list[Event], n: int) -> int:
    """Compare events as far as both know them; return how many of all balls that are."""
    compared = 0
    for one, other in zip(by_ball(some, n), by_ball(others, n), strict=True):
        known = min(len(one), len(other))
        assert [e[1:] for e in one[:known]] == [e[1:] for e in other[:known]]
        times = [e[0] for e in one[:known]]
        assert times == pytest.approx([e[0] for e in other[:known]], abs=ROOM)
        compared += known
    return compared


def check(scene) -> int:
    """Compare a shot with its integration; return how many events were compared."""
    from integrated_flight import integrate  # scipy is there for developers alone

    n = len(scene.balls)
    integrated = integrate(scene)
    certificate = certify(scene, CertifiedSettings(), cached=False)
    result = simulate(scene, record="events")
    assert result.events is not None
    proved = [(float(e.t), int(e.kind), e.a, e.b) for e in certificate.events]
    found = [tuple(row) for row in result.events[["t", "kind", "a", "b"]].tolist()]
    check_same(found, integrated.events, n)
    # What is proved to its end the integration ends, too: it leaves out no more than a proof does.
    assert integrated.complete or not certificate.proved
    if certificate.proved:
        assert len(proved) == len(found) == len(integrated.events)
        places = np.array([ball.x for ball in integrated.balls])
        ends = np.array([[float(e) for e in place] for place in certificate.positions])
        assert ends == pytest.approx(places, abs=ROOM)
        assert result.rest_positions == pytest.approx(places, abs=ROOM)
    return check_same(proved, integrated.events, n)


@pytest.mark.slow
@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_flights_are_those_of_an_integration(name) -> None:
    assert check(find_scene(name)) >= 10


@pytest.mark.slow
@pytest.mark.parametrize("number", FEW)
def test_random_flights_are_those_of_an_integration(number) -> None:
    assert check(random_jump(number)) >= 1
