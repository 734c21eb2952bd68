"""The cushions of a scene for time-stepping engines."""

from __future__ import annotations

import math

import pytest
from shots import ball, scene_of

from ghostball.model import Disc, Scene, Segment, Table
from ghostball.reference_adapters.stepping.sides import (
    CornerNames,
    Normals,
    corners_of,
    parts_of,
    sides_of,
)

L_SHAPE = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]


def on(table: Table) -> Scene:
    return scene_of(ball((0.5, 0.5)), table=table)


def test_a_rectangle_has_sides_and_a_table_with_pockets_parts() -> None:
    posts = [{"centre": (0.2, 0.2), "radius": 0.05}]
    plain = on(Table.model_validate({"length": 1.0, "width": 1.0, "posts": posts}))
    assert len(sides_of(plain)) == 4
    assert [type(part) for part in parts_of(plain)] == [Disc]
    pool = parts_of(on(Table.model_validate("wpa-9ft")))
    assert sides_of(on(Table.model_validate("wpa-9ft"))) == ()
    assert sum(isinstance(part, Segment) for part in pool) == 6 + 12
    assert sum(isinstance(part, Disc) for part in pool) == 12
    assert parts_of(scene_of(ball((0.5, 0.5)))) == ()


def test_a_normal_is_that_of_the_line_or_of_the_nearest_part() -> None:
    plain = Normals(on(Table(length=1.0, width=1.0)))
    assert plain.at(1, (0.9, 0.3)) == (-1.0, 0.0)
    shape = Normals(on(Table.model_validate({"vertices": L_SHAPE})))
    first = 4
    assert shape.at(first + 2, (1.5, 0.9)) == (0.0, -1.0)
    diagonal = shape.at(first + 2, (0.9, 0.9))
    assert diagonal == pytest.approx((-math.sqrt(0.5), -math.sqrt(0.5)), rel=1e-14)


def test_corners_that_point_into_the_table_and_what_they_are_called() -> None:
    scene = on(Table.model_validate({"vertices": L_SHAPE}))
    (corner,) = corners_of(scene)
    assert corner.place == (1.0, 1.0)
    names = CornerNames(scene)
    before, after = corner.before, corner.after
    assert (before, after) == (6, 7)  # "side-3" and "side-4"
    assert names.name(before, (0.98, 0.98)) == names.name(after, (0.98, 0.98)) == before
    assert names.name(after, (0.97, 1.2)) == after
    assert names.name(0, (0.98, 0.98)) == 0
    assert not CornerNames(on(Table.model_validate("wpa-9ft")))
    assert not CornerNames(on(Table(length=1.0, width=1.0)))
