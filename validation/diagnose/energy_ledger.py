"""Where the energy of a shot went: into collisions of each kind, or into the cloth between events.

It is found from the stored motion alone, ball by ball. An exact motion is stored on both sides of
each event (`validation.runs.sampling.motion_of`), and between two events a ball is in one phase: so
each loss belongs to one entry. Frames of a stepping engine are joined by straight lines, and an
event falls between two of them: what is lost there at the event, and what on the way, they don't
say.
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
    Scene,
    first_energy,
    initial_state,
)
from ghostball.model.arrays import FloatArray
from ghostball.validation.results.records import Motion

SEVERAL = "simultaneous events of several kinds"
"""Collisions of both kinds at one instant that share a ball: no order, so no loss of each."""

UNSTORED = "at events without stored states"
"""Of the balls that collide where a log is too long for all of its states to be kept."""

PHASES = {Phase.SLIDING: "sliding", Phase.ROLLING: "rolling", Phase.RESTING: "spinning in place"}
"""Names of what is lost on the way, by the phase of the ball."""

ENTRIES = (*(kind.label for kind in COLLISION_KINDS), SEVERAL, UNSTORED, *PHASES.values())
"""Every entry in the order of tables."""

FRAMES = "its frames don't separate losses at events from losses between them"
NOT_FINITE = "its motion contains NaN or infinity"


@dataclass(frozen=True)
class EnergyLedger:
    """Where the energy of one run went.

    `initial`, `final` [J]: before anything happens, and at the end of the stored motion; nan where
        it blew up.
    `entries` [J]: what was lost by entry, those of `ENTRIES` that there are; negative where energy
        was gained. None where the motion doesn't tell, and `why` says so.
    `counts`: how many collisions there were, by kind.
    """

    initial: float
    final: float
    entries: dict[str, float] | None
    counts: dict[str, int] = field(default_factory=dict)
    why: str = ""

    @property
    def lost(self) -> float:
        """Energy lost in all [J]."""
        return self.initial - self.final


def ledger_of(scene: Scene, motion: Motion) -> EnergyLedger:
    """Return where the energy of a run went, from its stored motion.

    The entries add up to `lost` but for rounding: the sum telescopes over the stored states. The
    last instant before an event is one double earlier, so that nothing to speak of is lost on the
    way between the two. A ball's vertical spin decays in every phase, and is counted with it;
    sustained contact is no event, so that what it costs is counted with the phase, too.
    """
    initial = first_energy(scene)
    energy = ball_energies(scene, motion)
    final = float(np.sum(energy[-1]))
    counts = {
        kind.label: int(np.count_nonzero(motion.events["kind"] == kind)) for kind in COLLISION_KINDS
    }
    if motion.phases is None:
        return EnergyLedger(initial, final, None, counts, FRAMES)
    if not np.all(np.isfinite(energy)):
        return EnergyLedger(initial, final, None, counts, NOT_FINITE)
    return EnergyLedger(initial, final, _entries(scene, motion, energy), counts)


def ball_energies(scene: Scene, motion: Motion) -> FloatArray:
    """Return the energy of each ball, (k, n) float64 [J], at the times of a stored motion."""
    return _energies(scene, motion.positions, motion.velocities, motion.angular_velocities)


def _energies(
    scene: Scene, positions: FloatArray, velocities: FloatArray, spins: FloatArray
) -> FloatArray:
    inertia = 0.4 * scene.masses * scene.radii**2
    with np.errstate(invalid="ignore", over="ignore"):  # of an engine that blew up
        energy: FloatArray = (
            0.5 * scene.masses * np.sum(velocities**2, axis=2)
            + 0.5 * inertia * np.sum(spins**2, axis=2)
            + scene.physics.gravity * scene.masses * (positions[:, :, 2] - scene.radii)
        )
    return energy


def _entries(scene: Scene, motion: Motion, energy: FloatArray) -> dict[str, float]:
    assert motion.phases is not None  # `ledger_of` saw to it
    phases = motion.phases
    # The first stored state is that after the events of t = 0.
    before = _energies(scene, *initial_state(scene))
    # Row i is what each ball loses on the way to sample i; row 0 is lost at t = 0.
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
    """Return, for each sample on the way to which balls collide: its row, and the collisions.

    With whether they are all of one instant, whose last instant before is stored.
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
    """Return balls that collide with each other, directly or through others, and in what kinds."""
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
