"""What ensembles say: whose distributions differ from our engine's, in what, and by how much.

Our engine is the one to compare with since it has every scene's own model, without time steps. That
makes it no truth: the comparison is one of codes. Its null test, against members of its own that no
other engine runs, is a check: it fails where differences are seen that can't be there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from ghostball.validation.ensembles.ensemble_record import (
    INSTANTS,
    REFERENCE,
    EnsembleRecord,
    Members,
)
from ghostball.validation.ensembles.ensembles_folder import Ensembles
from ghostball.validation.ensembles.members import Stream
from ghostball.validation.ensembles.statistics import TwoSample, holm, smallest_p, two_sample_tests

Quantity = Literal["rest", "ball-ball", "ball-cushion", "energy"]

QUANTITIES: Final[dict[Quantity, str]] = {
    "rest": "rest positions",
    "ball-ball": "ball-ball collisions",
    "ball-cushion": "ball-cushion collisions",
    "energy": "energy",
}
"""What is compared, and its name."""

ENERGY_PARTS: Final = (0.1, 0.25, 0.5, 0.75, 0.9)
"""When energies are compared: parts of the time that the unperturbed scene takes in our engine."""

LEVEL: Final = 0.05
"""A corrected p-value below this is a difference."""

NULL_LEVEL: Final = 0.01
"""One of the null test below this fails it: of sound runs one in a hundred would, at most."""

FEWEST_PERMUTATIONS: Final = 999
PERMUTATIONS_PER_TEST: Final = 200
"""So that the least corrected p-value is at most half the level of the null test."""


@dataclass(frozen=True)
class Comparison:
    """One quantity of one ensemble against the same of our engine's.

    Attributes
    ----------
    scene, label : str
    stream : "shots" or "null"
        "null": our engine against itself.
    quantity : Quantity
    ended, reference_ended : int
        Members that came to their end, and so are compared.
    test : TwoSample or None
        The energy distance is in m (of all balls jointly, as root mean square over them), a number
        of collisions, or a part of the initial energy. None where too few members came to an end.
    p : float or None
        Corrected for the number of all tests of the run.
    least : float or None
        Below this, with so many members and tests, it can't be.
    """

    scene: str
    label: str
    stream: Stream
    quantity: Quantity
    ended: int
    reference_ended: int
    test: TwoSample | None
    p: float | None = None
    least: float | None = None

    @property
    def judged(self) -> bool:
        """Whether there are enough members for a difference to show."""
        return self.least is not None and self.least < LEVEL

    @property
    def differs(self) -> bool:
        """Whether the difference is significant."""
        return self.p is not None and self.p < LEVEL


@dataclass(frozen=True)
class NullTest:
    """Our engine against itself, over all scenes.

    Attributes
    ----------
    passed : bool or None
        None where it could not fail, for there are too few members, or it could not be made.
    sentence : str
        What it says, with its numbers.
    """

    passed: bool | None
    sentence: str


@dataclass(frozen=True, eq=False)
class Compared:
    """All that a run of ensembles says.

    Attributes
    ----------
    comparisons : list of Comparison
        Scene by scene, engine by engine, quantity by quantity.
    null : NullTest
    permutations : int
    """

    comparisons: list[Comparison]
    null: NullTest
    permutations: int

    def of(self, scene: str, label: str, stream: Stream = "shots") -> list[Comparison]:
        """Return the comparisons of one ensemble, by quantity; [] where it did not run."""
        wanted = (scene, label, stream)
        return [one for one in self.comparisons if (one.scene, one.label, one.stream) == wanted]


def compare(ensembles: Ensembles) -> Compared:
    """Compare every engine's ensembles with our engine's.

    Raises
    ------
    ResultsError
        Where what the members did can't be read.

    Notes
    -----
    Holm's correction is over all tests of the run, those of the null test included. Members that
    came to no end are left out: `EnsembleRecord.stopped` and `failed` have them.
    """
    return _compare(ensembles.folder, ensembles.run.run)


@lru_cache(maxsize=1)
def _compare(folder: Path, run: str) -> Compared:  # noqa: ARG001 - tells two states apart
    ensembles = Ensembles.load(folder)
    assert ensembles is not None  # it was just read
    pairs = list(_pairs(ensembles))
    permutations = permutations_for(len(QUANTITIES) * len(pairs))
    comparisons = [
        one
        for record, reference in pairs
        for one in _tests(ensembles, record, reference, permutations)
    ]
    tested = [one.test.p for one in comparisons if one.test is not None]
    corrected = iter(holm(tested))
    comparisons = [
        one
        if one.test is None
        else replace(one, p=next(corrected), least=_least(one, len(tested), permutations))
        for one in comparisons
    ]
    return Compared(comparisons, _null_test(comparisons), permutations)


def permutations_for(tests: int) -> int:
    """Return how many permutations make a corrected p-value of so many tests small enough."""
    return max(FEWEST_PERMUTATIONS, PERMUTATIONS_PER_TEST * tests - 1)


def _pairs(ensembles: Ensembles) -> Iterator[tuple[EnsembleRecord, EnsembleRecord]]:
    """Yield each ensemble that ran and that of our engine which it is compared with."""
    for record in ensembles.records:
        reference = ensembles.of(record.scene).get(REFERENCE)
        if record is reference or record.outcome != "ran":
            continue
        if reference is not None and reference.outcome == "ran":
            yield record, reference


def _tests(
    ensembles: Ensembles, record: EnsembleRecord, reference: EnsembleRecord, permutations: int
) -> Iterator[Comparison]:
    one, other = ensembles.members(record), ensembles.members(reference)
    tests: list[TwoSample | None] = [None] * len(QUANTITIES)
    if min(len(one), len(other)) >= 2:
        samples = [
            (quantity_of(one, record, q), quantity_of(other, reference, q)) for q in QUANTITIES
        ]
        tests = list(two_sample_tests(samples, permutations))
    for quantity, test in zip(QUANTITIES, tests, strict=True):
        yield Comparison(
            record.scene, record.label, record.stream, quantity, len(one), len(other), test
        )


def quantity_of(
    members: Members, record: EnsembleRecord, quantity: Quantity
) -> NDArray[np.float64]:
    """Return one quantity of the members, (m, d) float64, in the unit of `Comparison.test`."""
    if quantity == "rest":
        n = members.rest_positions.shape[1]
        return members.rest_positions.reshape(len(members), 2 * n) / math.sqrt(n)
    if quantity == "energy":
        instants = [round(part * (INSTANTS - 1)) for part in ENERGY_PARTS]
        # A scene in which nothing moves has no energy, at any time.
        energy: NDArray[np.float64] = members.energy[:, instants] / (record.energy_initial or 1.0)
        return energy
    column = 0 if quantity == "ball-ball" else 1
    return members.counts[:, column : column + 1].astype(np.float64)


def _least(one: Comparison, tests: int, permutations: int) -> float:
    """Return the least p-value that a test can have, corrected for the number of all tests."""
    return tests * max(1.0 / (permutations + 1), smallest_p(one.ended, one.reference_ended))


def _null_test(comparisons: list[Comparison]) -> NullTest:
    """Judge our engine against itself."""
    made = [one for one in comparisons if one.stream == "null"]
    tested = [one for one in made if one.test is not None and one.p is not None]
    if not tested:
        return NullTest(None, "not made: of our engine's members too few came to an end")
    number = sum(one.test is not None for one in comparisons)
    members = min(min(one.ended, one.reference_ended) for one in tested)
    if max(one.least for one in tested if one.least is not None) >= NULL_LEVEL:
        return NullTest(
            None,
            f"not judged: with {members} members and {number} tests no corrected p-value can be "
            f"below {NULL_LEVEL:g}. Ask for more members",
        )
    worst = min(tested, key=lambda one: one.p or 0.0)
    assert worst.p is not None
    scenes = len({one.scene for one in tested})
    in_all = f"{len(tested)} tests in {scenes} scene{'s' if scenes > 1 else ''}"
    if worst.p < NULL_LEVEL:
        return NullTest(
            False,
            f"failed: two independent ensembles of `{REFERENCE}` itself differ in their "
            f"{QUANTITIES[worst.quantity]} in {worst.scene}, p = {worst.p:.2g} after correction "
            f"({in_all}). Nothing that the ensembles say can be trusted",
        )
    return NullTest(
        True,
        f"passed: no difference between independent ensembles of `{REFERENCE}` itself, {in_all}, "
        f"least p after correction {worst.p:.2g}",
    )
