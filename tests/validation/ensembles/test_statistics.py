"""Energy distance against closed forms, p-values against all partitions, Holm against examples."""

import math
from itertools import combinations
from statistics import NormalDist

import numpy as np
import pytest

from ghostball.validation.ensembles.statistics import (
    distances,
    holm,
    smallest_p,
    two_sample_tests,
)


def column(*values: float) -> np.ndarray:
    return np.array(values, dtype=np.float64)[:, np.newaxis]


def energy_distance(x: np.ndarray, y: np.ndarray) -> float:
    return 2.0 * distances(x, y).mean() - distances(x, x).mean() - distances(y, y).mean()


def test_distances_are_those_of_the_plane():
    x, y = np.array([[0.0, 0.0], [3.0, 0.0]]), np.array([[0.0, 4.0]])
    assert distances(x, y).tolist() == [[4.0], [5.0]]


def test_two_point_sets_by_hand():
    # <|X - Y|> = (2 + 4 + 1 + 3) / 4, <|X - X'|> = 1/2, <|Y - Y'|> = 2/2.
    assert energy_distance(column(0.0, 1.0), column(2.0, 4.0)) == pytest.approx(3.5, rel=1e-15)
    # Two points 3 m apart: 2 x 3; twice the squared area between the steps.
    assert energy_distance(column(0.0), column(3.0)) == 6.0


@pytest.mark.parametrize(("shift", "scale"), [(0.5, 1.0), (2.0, 1.0), (0.0, 3.0), (1.0, 2.0)])
def test_two_gaussians_in_closed_form(shift, scale):
    def mean_distance(mean, deviation):  # of N(mean, deviation^2) from 0: the folded normal
        u = mean / deviation
        return deviation * math.sqrt(2 / math.pi) * math.exp(-u * u / 2) + mean * math.erf(
            u / math.sqrt(2)
        )

    expected = (
        2.0 * mean_distance(shift, math.hypot(1.0, scale))
        - mean_distance(0.0, math.sqrt(2.0))
        - mean_distance(0.0, scale * math.sqrt(2.0))
    )
    quantiles = [(i + 0.5) / 1000 for i in range(1000)]
    x = column(*map(NormalDist().inv_cdf, quantiles))
    y = column(*map(NormalDist(shift, scale).inv_cdf, quantiles))
    assert energy_distance(x, y) == pytest.approx(expected, rel=2e-3)


def test_the_test_gives_the_distance_and_its_part_of_the_most_possible():
    x, y = column(0.0, 1.0), column(2.0, 4.0)
    (found,) = two_sample_tests([(x, y)], 99)
    assert found.distance == pytest.approx(3.5, rel=1e-15)
    assert found.effect == pytest.approx(3.5 / 5.0, rel=1e-15)


@pytest.mark.parametrize(("n", "m"), [(4, 4), (3, 5)])
def test_p_is_that_of_all_partitions(n, m):
    generator = np.random.default_rng(7)
    x, y = generator.normal(size=(n, 2)), generator.normal(0.9, size=(m, 2))
    both = np.concatenate([x, y])
    every = [
        energy_distance(both[list(those)], np.delete(both, those, axis=0))
        for those in combinations(range(n + m), n)
    ]
    exact = np.mean(np.array(every) >= energy_distance(x, y) - 1e-12)
    (found,) = two_sample_tests([(x, y)], 20_000)
    assert found.p == pytest.approx(exact, abs=4.0 * math.sqrt(exact / 20_000) + 1e-4)
    assert min(np.mean(np.array(every) >= value - 1e-12) for value in every) == pytest.approx(
        smallest_p(n, m)
    )


def test_p_is_uniform_where_both_samples_are_of_one_distribution():
    generator = np.random.default_rng(1)
    p = []
    for _ in range(400):
        x, y = generator.normal(size=(12, 3)), generator.normal(size=(12, 3))
        p += [found.p for found in two_sample_tests([(x, y)], 199)]
    assert min(p) >= 1.0 / 200.0
    # Kolmogorov and Smirnov at 1 in 1000; the lattice of p adds 1/200.
    ranks = (np.arange(400) + 0.5) / 400
    assert np.abs(np.sort(p) - ranks).max() < 1.95 / 20.0 + 1.0 / 200.0


def test_the_same_samples_are_never_told_apart():
    x = np.random.default_rng(2).normal(size=(15, 4))
    (found,) = two_sample_tests([(x, x)], 499)
    assert (found.distance, found.effect, found.p) == (0.0, 0.0, 1.0)
    (constant,) = two_sample_tests([(column(3.0, 3.0), column(3.0, 3.0))], 99)
    assert (constant.distance, constant.effect, constant.p) == (0.0, 0.0, 1.0)


def test_a_shift_and_a_spread_are_both_seen():
    generator = np.random.default_rng(3)
    x = generator.normal(size=(40, 2))
    shifted, spread = x[::-1] + np.array([1.5, 0.0]), 3.0 * generator.normal(size=(40, 2))
    for other in (shifted, spread):
        (found,) = two_sample_tests([(x, other)], 999)
        assert found.p == 1.0 / 1000.0  # never 0
        assert found.effect > found.chance


def test_several_quantities_are_tested_as_one_by_one_and_alike_every_time():
    generator = np.random.default_rng(4)
    pairs = [(generator.normal(size=(9, d)), generator.normal(size=(7, d))) for d in (1, 3)]
    together = two_sample_tests(pairs, 500)
    assert together == [two_sample_tests([pair], 500)[0] for pair in pairs]


def test_holm_of_published_examples():
    # R's p.adjust(c(0.01, 0.04, 0.03, 0.005), "holm"), the example in most textbooks: of alpha =
    # 0.05 the first and the last are rejected.
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    # SAS/STAT User's Guide, PROC MULTTEST, "Inputting Raw p-Values": 24 tests, the least 0.03498.
    raw = [0.28282, 0.30688, 0.71022, 0.77175, 0.78180, 0.88581, 0.54685, 0.84978]
    raw += [0.24228, 0.58977, 0.03498, 0.41607, 0.31631, 0.05254, 0.45061, 0.75758]
    raw += [0.12496, 0.49485, 0.21572, 0.50505, 0.94372, 0.81260, 0.77596, 0.36889]
    corrected = holm(raw)
    assert corrected[10] == pytest.approx(0.83952)
    assert [value for k, value in enumerate(corrected) if k != 10] == [1.0] * 23


def test_holm_keeps_order_and_ties():
    assert holm([]) == []
    assert holm([0.2, 0.2, 0.001]) == pytest.approx([0.4, 0.4, 0.003])
