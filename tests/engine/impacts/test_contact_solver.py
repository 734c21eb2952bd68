"""Tests of the contact solver: impulses end every approach and dissipate energy, in any order."""

from __future__ import annotations

import itertools
import math
import random

import numpy as np
import pytest
from kernels import entry_to, room_for_contacts

from ghostball.engine.core import state as st
from ghostball.engine.core.contacts import contacts_in
from ghostball.engine.core.kernel import COMPILED
from ghostball.engine.core.rows import ContactRow, column_of
from ghostball.engine.core.state import Contacts
from ghostball.engine.impacts import contact_solver
from ghostball.engine.impacts.contact_solver import end_approach, gain_of

end_approach, gain_of = map(entry_to, (end_approach, gain_of))

ROOT3 = math.sqrt(3.0)
BOTTOM = -3  # -1 minus the index of the cushion
TOP = -4

FORCE, NX, RATE, PRODUCT = (
    column_of(ContactRow, field) for field in ("force", "nx", "rate", "product")
)


class Group:
    """Balls of diameter 1 that touch each other and horizontal cushions, about to collide."""

    def __init__(self, places, masses, velocities, low=None, high=None):
        self.masses, self.velocities = np.array(masses), np.array(velocities, dtype=float)
        self.ends, self.normals = [], []
        for i, j in itertools.combinations(range(len(places)), 2):
            between = np.subtract(places[j], places[i])
            if abs(math.hypot(*between) - 1.0) < 1e-9:
                self.ends.append((i, j))
                self.normals.append(between / math.hypot(*between))
        for i, (_, y) in enumerate(places):
            for line, cushion, normal in ((low, BOTTOM, (0, -1)), (high, TOP, (0, 1))):
                if line is not None and abs(abs(y - line) - 0.5) < 1e-9:
                    self.ends.append((i, cushion))
                    self.normals.append(np.array(normal, dtype=float))

    def rates(self, velocities):
        return np.array(
            [
                np.dot(n, (velocities[b] if b >= 0 else 0.0) - velocities[a])
                for (a, b), n in zip(self.ends, self.normals, strict=True)
            ]
        )

    def contacts(self) -> Contacts:
        contacts = contacts_in(*room_for_contacts(len(self.masses)))
        for row, mass in zip(contacts.motion, self.masses, strict=True):
            if COMPILED:
                row["effective_mass"] = mass
            else:
                row.effective_mass = mass
        count = len(self.ends)
        contacts.ends[:count, st.FIRST : st.SECOND + 1] = self.ends
        contacts.columns[:count, NX : NX + 2] = self.normals
        contacts.columns[:count, RATE] = self.rates(self.velocities)
        return contacts

    def solve(self) -> tuple[bool, np.ndarray]:
        """Return whether the impulses were found, and the velocities afterwards."""
        contacts, count = self.contacts(), len(self.ends)
        solved = end_approach(contacts, count, 0.0)
        assert np.all(contacts.columns[:count, FORCE] >= 0.0)
        return solved, self.velocities + self.gains(contacts)

    def gains(self, contacts):
        return np.array([gain_of(contacts, k) for k in range(len(self.masses))])

    def energy(self, velocities):
        finite = np.isfinite(self.masses)
        return 0.5 * np.sum(self.masses[finite] * np.sum(velocities[finite] ** 2, axis=1))


def patch(chance: random.Random, n: int) -> list[tuple[float, float]]:
    """Return n sites of a triangular lattice, each next to an earlier one."""
    steps = [(1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1)]
    cells = [(0, 0)]
    while len(cells) < n:
        (a, b), (da, db) = chance.choice(cells), chance.choice(steps)
        if (a + da, b + db) not in cells:
            cells.append((a + da, b + db))
    return [(a + 0.5 * b, 0.5 * ROOT3 * b) for a, b in cells]


def random_group(seed: int, ratio: float) -> Group:
    chance = random.Random(seed)
    n = chance.randint(2, 9)
    places = patch(chance, n)
    masses = [ratio ** chance.uniform(-0.5, 0.5) for _ in range(n)]
    velocities = [
        (chance.gauss(0, 1), chance.gauss(0, 1)) if chance.random() < 0.6 else (0.0, 0.0)
        for _ in range(n)
    ]
    if chance.random() < 0.3:  # a ball at rest stays at rest
        masses = [m if any(v) else math.inf for m, v in zip(masses, velocities, strict=True)]
    low = min(y for _, y in places) - 0.5 if chance.random() < 0.5 else None
    high = max(y for _, y in places) + 0.5 if chance.random() < 0.5 else None
    return Group(places, masses, velocities, low, high)


@pytest.mark.compiled
@pytest.mark.parametrize("ratio", [1.0, 10.0, 1e4])
def test_no_approach_is_left_and_no_energy_gained(ratio):
    for seed in range(2000):
        group = random_group(seed, ratio)
        before = group.rates(group.velocities)
        if not np.any(before < 0.0):
            continue
        solved, after = group.solve()
        assert solved, seed
        fastest = -np.min(before)
        assert np.min(group.rates(after)) >= -1e-9 * fastest, seed
        assert group.energy(after) <= group.energy(group.velocities) * (1.0 + 1e-14), seed


@pytest.mark.parametrize("mass", [1.0, 17.0])
@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_balls_that_fill_a_table_from_cushion_to_cushion(n, mass):
    """There is one contact more than needed, so some impulses have no effect and must not grow."""
    places = [(0.0, float(k)) for k in range(n)]
    for seed in range(300):
        chance = random.Random(seed)
        velocities = [(chance.gauss(0, 1), chance.gauss(0, 1)) for _ in range(n)]
        masses = [mass if k % 2 else 1.0 for k in range(n)]
        group = Group(places, masses, velocities, -0.5, n - 0.5)
        solved, after = group.solve()
        assert solved
        assert np.max(np.abs(after[:, 1])) <= 1e-9  # nothing can move across
        assert np.array_equal(after[:, 0], group.velocities[:, 0])


def test_a_ball_that_cannot_move_stops_the_balls_beside_it():
    group = Group(
        [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)],
        [1.0, math.inf, 1.0],
        [(1.0, 0.5), (0.0, 0.0), (-2.0, 0.0)],
    )
    solved, after = group.solve()
    assert solved
    assert after == pytest.approx(np.array([(0.0, 0.5), (0.0, 0.0), (0.0, 0.0)]), abs=1e-15)


def test_a_nearly_wedged_ball_continues_along_the_gap():
    """Nothing stops a ball between a fixed ball and a cushion, off the line by rounding."""
    group = Group([(0.0, 0.0), (1e-14, 1.0)], [1.0, math.inf], [(1e-3, 2e-6), (0.0, 0.0)], -0.5)
    solved, after = group.solve()
    assert solved
    assert after[0] == pytest.approx([1e-3, 0.0], abs=1e-15)


@pytest.mark.parametrize("angle", [1e-3, 1e-5, 2e-7, 1e-9])
@pytest.mark.parametrize("slower", [1e-3, 0.5])
def test_only_the_needed_of_two_nearly_parallel_contacts_pushes(angle, slower):
    """The approach speeds at a rail and the jaw at its end differ: together, one would pull."""
    sine, cosine = math.sin(angle), math.cos(angle)
    group = Group([(0.0, 0.0)], [1.7], [((1.0 - cosine * slower) / sine, slower)])
    group.ends = [(0, TOP), (0, BOTTOM)]
    group.normals = [np.array([0.0, 1.0]), np.array([sine, cosine])]
    assert group.rates(group.velocities) == pytest.approx([-slower, -1.0])
    solved, after = group.solve()
    assert solved
    assert group.rates(after) == pytest.approx([1.0 - slower, 0.0], abs=1e-6)


@pytest.mark.parametrize("n", [4, 20])
def test_a_contact_that_stays_out_changes_nothing(n):
    """Its rate is inf, and inf times 0 was NaN: twenty contacts once got no forces."""
    places = [(float(k), 0.0) for k in range(n)]
    row = Group(places, [1.0] * n, [(1.0, 0.0)] + [(0.0, 0.0)] * (n - 1))
    contacts, shorter, count = row.contacts(), row.contacts(), n - 1
    contacts.columns[count - 1, RATE] = math.inf
    assert end_approach(contacts, count, 0.0)
    assert end_approach(shorter, count - 1, 0.0)
    assert contacts.columns[count - 1, FORCE] == 0.0
    expected = shorter.columns[: count - 1, FORCE]
    assert contacts.columns[: count - 1, FORCE] == pytest.approx(expected, abs=1e-12)


def test_an_approach_that_no_impulses_end_may_be_noise():
    """The gaps of a row between two cushions have a constant sum, with any impulses."""
    row = Group([(0.0, 0.0), (0.0, 1.0)], [1.0, 1.0], [(0.0, 0.0), (0.0, 0.0)], low=-0.5, high=1.5)
    contacts, rates = row.contacts(), (-1.0, 1.0, -1e-6)
    count = len(row.ends)
    contacts.columns[:count, RATE] = rates
    assert not end_approach(contacts, count, 2e-6)
    assert np.all(contacts.columns[:count, FORCE] >= 0.0)
    left = contacts.columns[:count, RATE] + contacts.columns[:count, PRODUCT]
    assert left.sum() == pytest.approx(-1e-6, rel=1e-6)
    assert left.min() >= -2e-6


@pytest.mark.parametrize("seed", range(40))
def test_the_order_of_balls_and_contacts_does_not_matter(seed):
    group = random_group(seed, 10.0)
    _, after = group.solve()
    chance = random.Random(seed)
    order = chance.sample(range(len(group.masses)), len(group.masses))
    where = {old: new for new, old in enumerate(order)}
    other = Group([], group.masses[order], group.velocities[order])
    for c in chance.sample(range(len(group.ends)), len(group.ends)):
        (a, b), n = group.ends[c], group.normals[c]
        ends = (where[a], where[b] if b >= 0 else b)
        turned = b >= 0 and chance.random() < 0.5
        other.ends.append(ends[::-1] if turned else ends)
        other.normals.append(-n if turned else n)
    if group.ends:
        assert np.array_equal(other.solve()[1], after[order])


@pytest.mark.compiled
def test_impulses_without_a_solution_only_dissipate():
    for seed in range(300):
        group = random_group(seed, 10.0)
        if not np.any(group.rates(group.velocities) < 0.0):
            continue
        contacts, count = group.contacts(), len(group.ends)
        chance = random.Random(seed)
        contacts.columns[:count, FORCE] = [chance.gauss(0, 3) for _ in range(count)]
        entry_to(contact_solver._take_energy)(contacts, count)
        gains = group.gains(contacts)
        before, after = group.velocities, group.velocities + gains
        assert group.energy(after) <= group.energy(before) * (1.0 + 1e-14)
        elastic = group.velocities + 2.0 * gains
        assert group.energy(elastic) <= group.energy(before) * (1.0 + 1e-14)
