"""A small results folder, written by hand: balls move on straight lines at known speeds."""

from pathlib import Path

import numpy as np
from stored_records import record

from ghostball.model import EVENT_DTYPE, Ball, EventKind, Scene, Table
from ghostball.validation.checks.accuracy import kind_of
from ghostball.validation.results.records import Accuracy
from ghostball.validation.results.store import (
    CLOSED_FORM,
    OUR_ENGINE,
    CaseRecord,
    Check,
    Motion,
    ResultsWriter,
)

LABELS = [
    "ghostball",
    "pymunk",
    "pymunk:contact_steps=exact",
    "pymunk:config=naive",
    "pybullet",
    "paper-discrete",
    "newcomer:dt=1e-3",
]
TABLE = Table(length=2.54, width=1.27)
R = 0.028575

# For each scene: title, truth, start of each ball, its corners (t, x, y) after that, collisions.
RACK = [(1.905 + 0.0496 * i, 0.635 + 0.0288 * k) for i in range(3) for k in range(-i, i + 1, 2)]
FAN = [
    [(1.0, x, y), (3.0, x + 0.15 * np.cos(k), y + 0.4 * np.sin(1.3 * k))]
    for k, (x, y) in enumerate(RACK)
]
SHOTS = {
    "stop": ("One ball rolls to rest", CLOSED_FORM, [[(0, 0.5, 0.6), (2, 1.5, 0.8)]], []),
    "head-on": (
        "Both on a line",
        CLOSED_FORM,
        [
            [(0, 0.5, 0.635), (1, 1.2, 0.635)],
            [(0, 1.25715, 0.635), (1, 1.25715, 0.635), (3, 2, 0.635)],
        ],
        [(1.0, EventKind.BALL_BALL, 0, 1)],
    ),
    "break-7": (
        "A break | of 7",
        OUR_ENGINE,
        [[(0, 0.6, 0.638), (1.0, 1.848, 0.636), (3, 1.5, 0.5)]]
        + [[(0, x, y), *corners] for (x, y), corners in zip(RACK, FAN, strict=True)],
        [(1.0, EventKind.BALL_BALL, 0, 1), (1.2, EventKind.BALL_BALL, 1, 2)],
    ),
    "wall-bounce": (
        "A cushion",
        CLOSED_FORM,
        [[(0, 1.9, 0.3), (1, 2.54 - R, 0.5), (2, 2.0, 0.7)]],
        [(1.0, EventKind.BALL_CUSHION, 0, 1)],
    ),
    "figure4-head-on": (
        "Head-on",
        CLOSED_FORM,
        [
            [(0, 0.8, 0.635), (1, 1.2128, 0.635)],
            [(0, 1.27, 0.635), (1, 1.27, 0.635), (2, 1.6, 0.635)],
        ],
        [(1.0, EventKind.BALL_BALL, 0, 1)],
    ),
    "figure4-skewed": (
        "Skewed",
        CLOSED_FORM,
        [
            [(0, 0.8, 0.645), (1, 1.2137, 0.645), (2, 1.25, 0.75)],
            [(0, 1.27, 0.635), (1, 1.27, 0.635), (2, 1.6, 0.58)],
        ],
        [(1.0, EventKind.BALL_BALL, 0, 1)],
    ),
}
SHOTS |= dict.fromkeys(
    ("thirty-degree-rule", "throw-by-angle", "throw-by-spin"),
    ("A sweep of one shot", OUR_ENGINE, *SHOTS["figure4-skewed"][2:]),
)
ERRORS = {
    "ghostball": 0.0,
    "pymunk": 2e-3,
    "pymunk:contact_steps=exact": 4e-7,
    "pymunk:config=naive": 0.09,
    "paper-discrete": 0.03,
    "newcomer:dt=1e-3": 1e-3,
}
EXCUSED = {
    "pymunk:config=naive": {
        "excused": "A newcomer <types> this.",
        "not_asked": ("overlap_max", "accuracy"),
    }
}


def scene_of(name: str) -> Scene:
    title, _, paths, _ = SHOTS[name]
    balls = [
        Ball(
            id="cue" if i == 0 else str(i),
            position=path[0][1:],
            velocity=(1.0, 0.0) if i == 0 else (0.0, 0.0),
        )
        for i, path in enumerate(paths)
    ]
    return Scene(name=name, title=title, tags=("synthetic",), table=TABLE, balls=balls)


def motion_of_shot(name: str, error: float) -> Motion:
    """Return a motion on straight lines between corners; `error` shifts the rest positions [m]."""
    _, _, paths, collisions = SHOTS[name]
    end = max(path[-1][0] for path in paths)
    events = np.array([(t, int(kind), a, b) for t, kind, a, b in collisions], dtype=EVENT_DTYPE)
    times = np.unique(np.concatenate([np.linspace(0.0, end, 61), events["t"]]))
    positions = np.empty((len(times), len(paths), 3))
    velocities = np.zeros_like(positions)
    for i, path in enumerate(paths):
        t, x, y = np.array(path).T
        shift = error * times / end
        positions[:, i, 0] = np.interp(times, t, x) - shift
        positions[:, i, 1] = np.interp(times, t, y)
        positions[:, i, 2] = R
        velocities[:, i] = np.gradient(positions[:, i], times, axis=0)
    energy = 0.5 * 0.170097 * (velocities**2).sum(axis=(1, 2))
    return Motion(
        events, times, positions, velocities, 0 * velocities, energy, 0.4 * energy, 0 * energy
    )


def case_of(name: str, label: str) -> tuple[CaseRecord, Motion | None]:
    scene = scene_of(name)
    _, truth, _, _ = SHOTS[name]
    if label == "pybullet":
        refused = {"outcome": "not-representable", "reason": "no table | with legs"}
        return record(label, scene, **refused), None
    if label == "newcomer:dt=1e-3" and name == "head-on":
        return record(label, scene, outcome="failed", reason="division by zero"), None
    error = ERRORS[label]
    motion, exact = motion_of_shot(name, error), motion_of_shot(name, 0.0)
    counts = {"ball-ball": 0, "ball-cushion": 0}
    for kind in motion.events["kind"]:
        counts[EventKind(int(kind)).label] += 1
    errors = np.linalg.norm(motion.positions[-1] - exact.positions[-1], axis=1)
    own = truth == OUR_ENGINE and label == "ghostball"
    limit = 5e-3
    checks = (
        Check(
            "rest_error_max",
            float(errors.max()),
            "at_most",
            limit,
            "m",
            None if own else bool(errors.max() <= limit),
            "a tenth of a ball",
        ),
    )
    case = record(
        label,
        scene,
        status="rest",
        accuracy=None if own else accuracy_of(label, float(errors.max()), counts),
        truth=truth,
        truth_positions=exact.positions[-1],
        truth_counts=counts,
        rest_positions=motion.positions[-1],
        ball_errors=errors,
        rest_time=float(motion.times[-1]),
        collision_counts=counts | {"ball-ball": 7}
        if label == "paper-discrete" and counts["ball-ball"]
        else counts,
        energy_initial=float(motion.energy[0]),
        energy_final=0.0,
        work={"events": 9, "joint_impacts": 2, "contact_steps": 0}
        if own
        else {"steps": 50, "pulls": 3 * (label == "paper-discrete")},
        wall_time=1e-3,
        metrics={
            "rest_error_max": float(errors.max()),
            "rest_error_rms": float(np.sqrt(np.mean(errors**2))),
            "rest_time_error": error,
            "ball_ball_count_error": 0,
            "ball_cushion_count_error": 0,
            "energy_difference_max": error,
            "wall_time": 1e-3,
        },
        checks=() if label.startswith("newcomer") else checks,
        **EXCUSED.get(label, {}),
    )
    # An engine that recorded no motion.
    return case, None if label.startswith("newcomer") else motion


def accuracy_of(label: str, error: float, counts: dict[str, int]) -> Accuracy:
    true = sum(counts.values())
    if label == "paper-discrete" and counts["ball-ball"]:
        return Accuracy("another shot", at=0.5, agree=true - 1, of=true)
    return Accuracy(kind_of(error) if error > 0.0 else "exact", error=error)


def write_results(folder: Path, scenes: list[str], labels: list[str]) -> Path:
    writer = ResultsWriter(folder)
    writer.begin(
        {"scenes": scenes, "engines": labels, "cpu": "a | b", "versions": {"numpy": "2.0"}}
    )
    for name in scenes:
        for label in labels:
            writer.write(case_of(name, label))
    writer.finish("complete")
    return folder
