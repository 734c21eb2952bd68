"""The sides of a table: where each cushion is, and which way is in."""

import pytest

from ghostball.model import CUSHIONS, Table

TABLE = Table(length=2.0, width=1.0)


@pytest.mark.parametrize(
    ("name", "nearest"),
    [("left", (0.0, 0.25)), ("right", (2.0, 0.25)), ("bottom", (0.5, 0.0)), ("top", (0.5, 1.0))],
)
def test_a_side_knows_where_it_is_and_which_way_is_in(name, nearest):
    """A normal that points outward, or a point that is on another line, has other distances."""
    side = TABLE.sides[CUSHIONS.index(name)]
    assert (side.name, side.cushion) == (name, CUSHIONS.index(name))
    assert side.distance(*nearest) == 0.0
    x, y = nearest
    assert side.distance(x + 0.125 * side.normal[0], y + 0.125 * side.normal[1]) == 0.125
    assert side.length == (1.0 if side.across == 0 else 2.0)
    assert all(side.distance(*end) == 0.0 for end in side.ends())
    assert all(side.distance(*end) == -0.25 for end in side.ends(beyond=0.5, outward=0.25))


def test_an_open_side_is_none():
    assert [side.name for side in Table(length=2.0, width=1.0, cushions=("top",)).sides] == ["top"]
