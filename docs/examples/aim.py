"""Plan a shot: the chance of each pocket, the window of directions, and the repair of a miss."""

import matplotlib.pyplot as plt
import numpy as np

from ghostball import Ball, Batch, Physics, Scene, Strike, Strokes, Table, simulate, simulate_starts
from ghostball.model import POCKETS

ERRORS = {"speed": 0.15, "direction": np.radians(0.2), "offset_left": 0.03, "offset_up": 0.03}
"""Standard deviations of a player's strokes [m/s, rad, radii, radii]."""

DRAWS = 200  # shots for each chance
SPEEDS = np.linspace(1.0, 4.0, 7)  # of the cue [m/s]
TARGET = POCKETS.index("bottom")  # the pocket that a player missed with this stroke
MISS = {"speed": 1.5, "direction": np.radians(-125.7), "offset_left": 0.0, "offset_up": 0.0}

PLACES = {"cue": (1.90, 0.54), "object": (1.66, 0.24), "b": (2.12, 0.68), "c": (1.20, 0.90)}
SCENE = Scene(
    name="plan",
    table=Table.model_validate("wpa-9ft"),
    physics=Physics(preset="pool"),
    balls=[Ball(id=name, position=place) for name, place in PLACES.items()],
)


def made(batch: Batch, pocket: int) -> np.ndarray:
    """Return whether each shot pockets the object ball, and no other ball."""
    return (batch.pocketed[:, 1] == pocket) & (batch.gone.sum(axis=1) == 1)


def directions(count: int) -> np.ndarray:
    """Return directions in which the cue ball would hit the object ball [rad]."""
    x, y = np.subtract(PLACES["object"], PLACES["cue"])
    half = np.arcsin(2.0 * SCENE.balls[0].radius / np.hypot(x, y))
    return np.arctan2(y, x) + np.linspace(-half, half, count)


def chances(angles: np.ndarray) -> np.ndarray:
    """Return the chance of each pocket for each direction and speed, with the player's errors."""
    angle, speed, _ = np.meshgrid(angles, SPEEDS, range(DRAWS), indexing="ij")
    strokes = Strokes(speed.ravel(), angle.ravel(), noise=ERRORS, seed=1)
    batch = simulate_starts(SCENE, strokes=strokes)
    return np.array([made(batch, p).reshape(speed.shape).mean(axis=2) for p in range(6)])


def window(pocket: int, direction: float, speed: float) -> np.ndarray:
    """Return the first and last direction of the window that makes the shot without errors."""
    angles = direction + np.radians(np.linspace(-2.0, 2.0, 4001))
    goes = made(simulate_starts(SCENE, strokes=Strokes(speed, angles)), pocket)
    nearest = np.flatnonzero(goes)[np.argmin(abs(angles[goes] - direction))]
    part = np.cumsum(~goes)  # the same number within a window
    return angles[goes & (part == part[nearest])][[0, -1]]


def repair(name: str) -> str:
    """Return the least change of one field of the missed stroke that makes the shot."""
    values = MISS[name] + ERRORS[name] * np.linspace(-8.0, 8.0, 3201)
    goes = made(simulate_starts(SCENE, strokes=Strokes(**{**MISS, name: values})), TARGET)
    changes = (values - MISS[name])[goes]
    if len(changes) == 0:
        return "none within 8 standard deviations"
    least = min(changes, key=abs)
    return f"{least:+.4f}, {abs(least) / ERRORS[name]:.1f} standard deviations"


def paths(strike: Strike) -> np.ndarray:
    """Return where the balls are during the shot, (times, balls, 3) [m]."""
    cue = Ball(id="cue", position=PLACES["cue"], strike=strike)
    shot = Scene(**{**dict(SCENE), "balls": [cue, *SCENE.balls[1:]]})
    result = simulate(shot, record="trajectory")
    return result.sample(np.linspace(0.0, result.rest_time, 2000)).positions


def main() -> None:
    """Print the plan, and draw it."""
    angles = directions(121)
    chance = chances(angles)
    figure, (table, chart) = plt.subplots(1, 2, figsize=(11, 3.8), width_ratios=(2, 1))
    table.add_patch(plt.Rectangle((0, 0), SCENE.table.length, SCENE.table.width, color="#d6eadf"))
    for hole in SCENE.table.holes:
        table.add_patch(plt.Circle(hole.centre, hole.radius, color="black"))
    for name, place in PLACES.items():
        table.add_patch(plt.Circle(place, SCENE.balls[0].radius, color="grey", zorder=3))
        table.annotate(name, place, xytext=(0, 7), textcoords="offset points", ha="center")

    pockets = np.argsort(-chance.max(axis=(1, 2)))
    for pocket in pockets[chance[pockets].max(axis=(1, 2)) > 0.15]:
        best = chance[pocket].max()
        i, j = np.unravel_index(chance[pocket].argmax(), chance[pocket].shape)
        low, high = window(pocket, angles[i], SPEEDS[j])
        print(
            f"{POCKETS[pocket]:12} {best:4.0%} at {np.degrees(angles[i]):.1f} degrees and "
            f"{SPEEDS[j]:.1f} m/s; window {np.degrees(low):.2f} to {np.degrees(high):.2f} degrees"
        )
        (line,) = chart.plot(np.degrees(angles), chance[pocket, :, j], label=POCKETS[pocket])
        for way in (low, high):
            moved = paths(Strike(speed=SPEEDS[j], direction=way))
            table.plot(*moved[:, 0, :2].T, ":", color=line.get_color(), linewidth=1)
            table.plot(*moved[:, 1, :2].T, color=line.get_color(), linewidth=1)
        hole = next(hole for hole in SCENE.table.holes if hole.pocket == pocket)
        table.annotate(f"{best:.0%}", hole.centre, color="white", ha="center", va="center", size=7)

    print(f"least change of one field that pockets the missed ball in {POCKETS[TARGET]}:")
    for name in ERRORS:
        print(f"  {name:12} {repair(name)}")
    title = "Paths at both ends of each accepted window of directions; dotted: the cue ball"
    table.set(aspect="equal", xlim=(-0.13, 2.67), ylim=(-0.15, 1.42), xlabel="x [m]")
    table.set_title(title, size=9)
    chart.set(
        xlabel="direction of the cue [degrees]", ylim=(0, 1), title="Chance at the best speed"
    )
    chart.legend()
    figure.savefig("aim.png", dpi=120, bbox_inches="tight")


if __name__ == "__main__":
    main()
