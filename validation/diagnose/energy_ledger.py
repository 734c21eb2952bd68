"""The energy losses of a shot, by kind of collision, and by phase between events.

They are computed from the stored motion, ball by ball. An exact motion is stored just before and
after each event (`validation.runs.sampling.motion_of`), and between two events a ball is in one
phase, so each loss belongs to one entry. Frames of a time-stepping engine don't separate losses at
an event from those between events, because an event falls between two frames.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field

import numpy as np

from ghostball.model import (
    COLLISION_KINDS,
    EventKind,
    Events,
    Phase,
    Samples,
    Scene,
    first_energy,
    initial_state,
)
from ghostball.model.arrays import FloatArray
from ghostball.validation.results.records import Motion

SEVERAL = "simultaneous events of several kinds"
"""Collisions of both kinds at one time that share a ball: their losses can't be separated."""

UNSTORED = "at events without stored states"
"""Losses of colliding balls if a log is too long for all of its states to be stored."""

PHASES = {Phase.SLIDING: "sliding", Phase.ROLLING: "rolling", Phase.RESTING: "spinning in place"}
"""Names of the losses between events, by the phase of the ball."""

ENTRIES = (*(kind.label for kind in COLLISION_KINDS), SEVERAL, UNSTORED, *PHASES.values())
"""All entries, in the order of tables."""

FRAMES = "its frames don't separate losses at events from losses between them"
NOT_FINITE = "its motion contains NaN or infinity"


@dataclass(frozen=True)
class EnergyLedger:
    """The energy losses of one run.

    `initial`, `final` [J]: at the start, and at the end of the stored motion; nan for a diverged
        run.
    `entries` [J]: losses by entry, for the entries of `ENTRIES` that occur; negative for gains.
        None if the motion doesn't determine them; `why` gives the reason.
    `counts`: number of collisions by kind.
    """

    initial: float
    final: float
    entries: dict[str, float] | None
    counts: dict[str, int] = field(default_factory=dict)
    why: str = ""

    @property
    def lost(self) -> float:
        """Total energy loss [J]."""
        return self.initial - self.final


def ledger_of(scene: Scene, motion: Motion) -> EnergyLedger:
    """Return the energy losses of a run, from its stored motion.

    The entries add up to `lost` up to rounding: the sum telescopes over the stored states. The
    state before an event is one double earlier, so losses in this interval are negligible. The
    vertical spin of a ball decays in every phase, and counts with the phase. Resting contact isn't
    an event, so its losses count with the phase, too.
    """
    initial = first_energy(scene)
    energy = _energies(
        scene, Samples(motion.positions, motion.velocities, motion.angular_velocities)
    )
    final = float(np.sum(energy[-1]))
    counts = {
        kind.label: int(np.count_nonzero(motion.events["kind"] == kind)) for kind in COLLISION_KINDS
    }
    if motion.phases is None:
        return EnergyLedger(initial, final, None, counts, FRAMES)
    if not np.all(np.isfinite(energy)):
        return EnergyLedger(initial, final, None, counts, NOT_FINITE)
    return EnergyLedger(initial, final, _entries(scene, motion, energy), counts)


def _energies(scene: Scene, samples: Samples) -> FloatArray:
    """Return the energy of each ball, (k, n) float64 [J]."""
    inertia = 0.4 * scene.masses * scene.radii**2
    with np.errstate(invalid="ignore", over="ignore"):  # diverged runs
        energy: FloatArray = (
            0.5 * scene.masses * np.sum(samples.velocities**2, axis=2)
            + 0.5 * inertia * np.sum(samples.angular_velocities**2, axis=2)
            + scene.physics.gravity * scene.masses * (samples.positions[:, :, 2] - scene.radii)
        )
    return energy


def _entries(scene: Scene, motion: Motion, energy: FloatArray) -> dict[str, float]:
    assert motion.phases is not None  # `ledger_of` has checked this
    phases = motion.phases
    # The first stored state is the one after the events at t = 0.
    before = _energies(scene, initial_state(scene))
    # Row i is the loss of each ball between samples i - 1 and i; row 0 is the loss at t = 0.
    drops = -np.diff(np.concatenate([before, energy]), axis=0)
    of_phase = np.concatenate([phases[:1], phases[:-1]])
    lost: dict[str, float] = defaultdict(float)
    on_the_way = np.ones(drops.shape, dtype=bool)
    for row, at_once, collisions in _instants(motion):
        for balls, kinds in _groups(collisions):
            entry = next(iter(kinds)).label if len(kinds) == 1 else SEVERAL
            lost[entry if at_once else UNSTORED] += float(np.sum(drops[row, balls]))
            on_the_way[row, balls] = False
    for phase, name in PHASES.items():
        mine = on_the_way & (of_phase == phase)
        if np.any(drops[mine] != 0.0):
            lost[name] += float(np.sum(drops[mine]))
    return {name: lost[name] for name in ENTRIES if name in lost}


def _instants(motion: Motion) -> list[tuple[int, bool, Events]]:
    """Return the samples with collisions just before them: row, whether stored, and collisions.

    "Stored" means that all of these collisions are at one time, and that the state just before is
    stored.
    """
    collisions = motion.events[np.isin(motion.events["kind"], COLLISION_KINDS)]
    rows = np.searchsorted(motion.times, collisions["t"], side="left")
    inside = rows < len(motion.times)
    found = []
    for row in np.unique(rows[inside]):
        here = collisions[rows == row]
        t = motion.times[row]
        stored = row == 0 or motion.times[row - 1] == np.nextafter(t, 0.0)
        found.append((int(row), bool(stored and np.all(here["t"] == t)), here))
    return found


def _groups(collisions: Events) -> list[tuple[list[int], set[EventKind]]]:
    """Return groups of balls that collide with each other, with their kinds of collisions."""
    groups: list[tuple[set[int], set[EventKind]]] = []
    for collision in collisions:
        kind = EventKind(int(collision["kind"]))
        balls = (
            {int(collision["a"]), int(collision["b"])}
            if kind is EventKind.BALL_BALL
            else {int(collision["a"])}
        )
        kinds = {kind}
        others = []
        for group in groups:
            if group[0] & balls:
                balls |= group[0]
                kinds |= group[1]
            else:
                others.append(group)
        groups = [*others, (balls, kinds)]
    return [(sorted(balls), kinds) for balls, kinds in groups]
