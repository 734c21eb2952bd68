"""A command ends with the most severe of several statuses."""

from itertools import pairwise

from ghostball.validation.exit_status import ExitStatus, worst

GRAVEST_FIRST = (141, 130, 3, 2, 1, 4, 0)


def test_the_gravest_status_wins_whatever_the_order():
    assert sorted(GRAVEST_FIRST) == sorted(ExitStatus)
    for graver, milder in pairwise(GRAVEST_FIRST):
        assert worst(milder, graver, 0) == worst(graver, milder) == graver
