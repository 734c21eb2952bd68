"""pooltool: a ball that hits two touching balls in line may raise ValueError.

Needs only pooltool: `pip install pooltool-billiards --extra-index-url https://archive.panda3d.org/`.

Three equal balls in a line, frictionless and elastic; the second and third touch. Expected after
the impacts: velocities 0, 0 and that of the first ball, as if contacts are resolved one after
another; at any position on the table.
"""

from importlib import metadata

import pooltool as pt
from pooltool.objects.ball.params import BallParams
from pooltool.physics.engine import PhysicsEngine
from pooltool.physics.resolve.ball_ball.frictionless_elastic import FrictionlessElastic
from pooltool.physics.resolve.resolver import Resolver

R, LEAST = 0.028575, 1e-9  # [m]; pooltool refuses a friction of 0
SPEED, AFTER = 1.5, 0.1  # [m/s], [s]: before any ball hits a cushion
SLIDING = 2


def play(place: float) -> list[float]:
    """Return the velocities after the impacts [m/s], if the first ball is at a place [m]."""
    params = BallParams(
        m=0.170097, R=R, u_s=LEAST, u_r=LEAST, u_sp_proportionality=LEAST, u_b=LEAST, e_b=1.0
    )
    balls = {}
    for k, y in enumerate((place, place + 0.1, place + 0.1 + 2 * R)):
        ball = balls[str(k)] = pt.Ball(id=str(k), params=params)
        ball.state.rvw[0] = [0.5, y, R]
    balls["0"].state.rvw[1] = [0.0, SPEED, 0.0]
    balls["0"].state.s = SLIDING
    system = pt.System(cue=pt.Cue(cue_ball_id="0", V0=0.0), table=pt.Table.default(), balls=balls)
    resolver = Resolver.default()
    object.__setattr__(resolver, "ball_ball", FrictionlessElastic())
    pt.simulate(system, engine=PhysicsEngine(resolver), inplace=True, t_final=AFTER)
    # The simulation may continue to the event after `t_final`.
    return [
        [state for state in ball.history if state.t <= AFTER][-1].rvw[1, 1]
        for ball in system.balls.values()
    ]


def main() -> None:
    """Simulate the shot at many places, and print unexpected results."""
    print(f"pooltool {metadata.version('pooltool-billiards')}; two touching balls are hit in line")
    print("expected: 0, 0 and 1.5 m/s, at every place")
    failed = []
    places = [0.2 + 0.0173 * k for k in range(60)]
    for place in places:
        try:
            found = play(place)
        except ValueError as error:
            failed.append(place)
            print(f"first ball at {place:.4f} m: ValueError: {error}")
        else:
            if max(abs(a - b) for a, b in zip(found, (0, 0, SPEED), strict=True)) > 1e-6:
                print(f"first ball at {place:.4f} m: {found}")
    print(f"raised at {len(failed)} of {len(places)} places")


if __name__ == "__main__":
    main()
