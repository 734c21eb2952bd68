"""The rules of tables with pockets, of polygons, and of posts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ghostball.model.scene.fields import SMALLEST, problem
from ghostball.model.scene.obstacles import POCKETS, Segment, gap_to, is_inside
from ghostball.model.scene.pockets import (
    Pocket,
    PocketOnTable,
    Pockets,
    facing_of,
    hole_of,
    place_pockets,
)
from ghostball.model.scene.sides import CUSHIONS, Point


def check_polygon(
    vertices: Sequence[Point], size: tuple[float, float], cushions: Sequence[str]
) -> None:
    """Check the vertices of a table, its size [m], and that each side has a cushion.

    Raises `PydanticCustomError` for the first rule that is broken.
    """
    if len(vertices) < 3:
        raise problem(
            f"`vertices` must be at least 3, got {len(vertices)}. Omit them for a rectangle",
            at=("vertices",),
        )
    _check_cushions(cushions, "vertices", "each side of a polygon has a cushion")
    low = tuple(min(point[k] for point in vertices) for k in (0, 1))
    high = tuple(max(point[k] for point in vertices) for k in (0, 1))
    if low != (0.0, 0.0):
        raise problem(
            f"`vertices` must have a smallest x and y of 0, got {low[0]:.9g} and {low[1]:.9g} m. "
            "Shift all vertices",
            at=("vertices",),
        )
    for axis, extent in zip("xy", high, strict=True):
        if extent < SMALLEST:
            raise problem(
                f"`vertices` must span at least {SMALLEST:g} m along {axis}, got {extent:.9g} m: "
                "there is no room between the sides. Move a vertex",
                at=("vertices",),
            )
    _check_simple(vertices)
    for name, given, there in zip(("length", "width"), size, high, strict=True):
        if given != there:
            raise problem(
                f"`{name}` must be that of the vertices, {there:.9g} m, got {given:.9g} m. Remove "
                "it",
                at=(name,),
            )
    area = math.fsum(a[0] * b[1] - b[0] * a[1] for a, b in _edges(vertices))
    if area <= 0.0:
        raise problem(
            "`vertices` must be counterclockwise, but are clockwise. Reverse their order",
            at=("vertices",),
        )


def _check_cushions(cushions: Sequence[str], beside: str, why: str) -> None:
    """Check that all four cushions are there, which is the default."""
    if tuple(cushions) != CUSHIONS:
        raise problem(
            f"`cushions` must not be given together with `{beside}`, got {list(cushions)}: {why}. "
            "Remove it",
            at=("cushions",),
        )


def _edges(vertices: Sequence[Point]) -> list[tuple[Point, Point]]:
    return list(pairwise([*vertices, vertices[0]]))


def _check_simple(vertices: Sequence[Point]) -> None:
    """Check that no side of a polygon is a point, and that sides meet only at common vertices."""
    edges, n = _edges(vertices), len(vertices)
    for k, (start, end) in enumerate(edges):
        if start == end:
            raise problem(
                f"`vertices[{(k + 1) % n}]` must differ from the previous vertex, got {end} m "
                "twice. Remove one",
                at=("vertices", (k + 1) % n),
            )
        if math.dist(start, end) < SMALLEST:
            raise problem(
                f"`vertices[{(k + 1) % n}]` must be at least {SMALLEST:g} m from the previous "
                f"vertex, got {math.dist(start, end):.9g} m. Remove one",
                at=("vertices", (k + 1) % n),
            )
    for k, edge in enumerate(edges):
        following = edges[(k + 1) % n]
        turns_back = _side(*edge, following[1]) == 0.0 and _dot(*edge, following[1]) < 0.0
        if turns_back:
            raise problem(
                f"`vertices[{(k + 1) % n}]` must not have two coincident sides. Move a vertex",
                at=("vertices", (k + 1) % n),
            )
        for other in range(k + 2, n if k else n - 1):
            if _meet(edge, edges[other]):
                raise problem(
                    f"`vertices` must form a polygon that doesn't cross itself, but the side from "
                    f"{edge[0]} to {edge[1]} m meets the side from {edges[other][0]} to "
                    f"{edges[other][1]} m. Reorder them",
                    at=("vertices", k),
                )


def _side(a: Point, b: Point, c: Point) -> float:
    """Return a positive number if c is left of the line from a to b, 0 on it, negative if right."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _dot(a: Point, b: Point, c: Point) -> float:
    """Return the dot product of b - a and c - b; it is negative if the path turns back at b."""
    return (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1])


def _meet(one: tuple[Point, Point], other: tuple[Point, Point]) -> bool:
    """Return whether two segments have a point in common."""
    (a, b), (c, d) = one, other
    first, second = _side(a, b, c), _side(a, b, d)
    third, fourth = _side(c, d, a), _side(c, d, b)
    if (first > 0.0) != (second > 0.0) and (third > 0.0) != (fourth > 0.0) and first != second:
        return True
    spans = ((a, b, c, first), (a, b, d, second), (c, d, a, third), (c, d, b, fourth))
    return any(side == 0.0 and _is_between(p, q, point) for p, q, point, side in spans)


def _is_between(a: Point, b: Point, c: Point) -> bool:
    """Return whether a point c on the line through a and b is between them."""
    return all(min(a[k], b[k]) <= c[k] <= max(a[k], b[k]) for k in (0, 1))


def check_posts(
    posts: Sequence[tuple[Point, float]],
    outline: Sequence[Point],
    size: tuple[float, float],
    pockets: Pockets | None,
) -> None:
    """Check that posts, given as centre and radius [m], are inside and clear of pockets.

    Raises `PydanticCustomError` for the first rule that is broken.
    """
    placed = [] if pockets is None else place_pockets(*size, pockets)
    for k, (centre, radius) in enumerate(posts):
        if not is_inside(outline, *np.array([centre]).T)[0]:
            raise problem(
                f"`posts[{k}].centre` must be inside the table, got {centre} m. Move the post",
                at=("posts", k, "centre"),
            )
        for pocket in placed:
            reach = radius - _gap_to_pocket(pocket, centre)
            if reach > 0.0:
                raise problem(
                    f"`posts[{k}]` must be clear of the mouth and the hole of the pocket "
                    f'"{POCKETS[pocket.pocket]}", got a centre of {centre} m and a radius of '
                    f"{radius:g} m, which reach {reach:.6g} m into it. Move the post, or lower its "
                    "radius",
                    at=("posts", k),
                )


def _gap_to_pocket(pocket: PocketOnTable, place: Point) -> float:
    """Return the distance of a place from a pocket's mouth and hole [m]; at most 0 inside."""
    shape = facing_of(pocket.shape, pocket.is_corner)
    lip = (pocket.shape.mouth / (math.sqrt(2.0) if pocket.is_corner else 2.0), 0.0)
    start, end = pocket.first.place(lip), pocket.second.place(lip)
    behind = (start, pocket.first.place(shape.end), pocket.second.place(shape.end), end)
    x, y = np.array([place]).T
    if is_inside(behind, x, y)[0]:
        return 0.0
    pieces = (Segment(0, start, end), pocket.hole)
    return min(float(gap_to(one, x, y)[0]) for one in pieces)


def check_pockets(size: tuple[float, float], cushions: Sequence[str], pockets: Pockets) -> None:
    """Check the pockets of a rectangle of a given size [m].

    Raises `PydanticCustomError` for the first rule that is broken.
    """
    _check_cushions(cushions, "pockets", "pockets lie between cushions")
    _check_rails(size, pockets)
    for name, shape in (("corner", pockets.corner), ("side", pockets.side)):
        if shape is not None:
            _check_size(name, shape, size)
            _check_pocket(name, shape)
    _check_holes(size, pockets)


def _check_size(name: str, pocket: Pocket, size: tuple[float, float]) -> None:
    """Check that a pocket is smaller than its table."""
    reach, width = pocket.depth + 2.0 * pocket.radius, min(size)
    if reach >= width:
        field = "depth" if pocket.depth > pocket.radius else "radius"
        raise problem(
            f"`pockets.{name}` must be smaller than the table, whose shorter side is {width:g} m, "
            f"got a shelf of {pocket.depth:.4g} m and behind it a hole of radius "
            f"{pocket.radius:.4g} m, {reach:.4g} m together. Give a smaller `{field}`",
            at=("pockets", name, field),
        )


def _check_pocket(name: str, pocket: Pocket) -> None:
    """Check that a pocket is open as far as its hole, and that the hole is wide enough."""
    is_corner = name == "corner"
    facing, hole = facing_of(pocket, is_corner), hole_of(pocket, is_corner)
    half = math.dist(facing.end, hole)
    if is_corner and hole[0] >= 0.0:
        raise problem(
            f"`pockets.{name}.depth` must put the middle of the hole behind the corner: it is "
            f"{pocket.depth + pocket.radius:.6g} m behind the middle of the mouth, and the corner "
            f"{pocket.mouth / 2.0:.6g} m. Give a larger depth, or a larger radius",
            at=("pockets", name, "depth"),
        )
    behind = math.dist(facing.start, facing.end)
    leads_out = (facing.end[1] < facing.start[1]) and behind > 0.0
    across = _crosses_axis(facing.end, is_corner)
    if across:
        raise problem(
            f"`pockets.{name}` must be open as far as the middle of its hole, which is "
            f"{pocket.depth + pocket.radius:.4g} m behind its mouth, but its facings, at "
            f"{pocket.angle:.4g} rad from a mouth of {pocket.mouth:.4g} m, meet "
            f"{_facings_meet(pocket, is_corner):.4g} m behind it. Give a larger mouth, or a "
            "smaller angle, radius or depth",
            at=("pockets", name),
        )
    if not leads_out:
        raise problem(
            f"`pockets.{name}` must be open as far as its hole, but its jaws, of radius "
            f"{pocket.jaw_radius:g} m, reach beyond it. Give a smaller `jaw_radius`",
            at=("pockets", name, "jaw_radius"),
        )
    if not half < pocket.radius:
        raise problem(
            f"`pockets.{name}.radius` must be more than {half:.6g} m, the distance of the facings "
            f"from the middle of the hole, got {pocket.radius:g} m: otherwise balls could pass the "
            "hole. Give a larger radius",
            at=("pockets", name, "radius"),
        )


def _crosses_axis(end: Point, is_corner: bool) -> bool:
    """Return whether a facing ends beyond the pocket's axis, in the coordinates of `Facing`."""
    return end[0] <= end[1] if is_corner else end[0] <= 0.0


def _facings_meet(pocket: Pocket, is_corner: bool) -> float:
    """Return the distance behind the mouth at which converging facings of a pocket meet [m]."""
    parallel = 0.75 * math.pi if is_corner else 0.5 * math.pi  # the angle of parallel facings
    return pocket.mouth / 2.0 / math.tan(pocket.angle - parallel)


def _check_rails(size: tuple[float, float], pockets: Pockets) -> None:
    """Check that a straight rail remains between two pockets, or between a pocket and a corner."""
    corner, side = pockets.corner, pockets.side
    corner_joint = facing_of(corner, is_corner=True).joint if corner else 0.0
    side_joint = facing_of(side, is_corner=False).joint if side else 0.0
    length, width = size
    free = {
        "length": length - 2.0 * (corner_joint + side_joint),
        "width": width - 2.0 * corner_joint,
    }
    for name, left in free.items():
        if left <= 0.0:
            raise problem(
                f"`pockets` must leave a part of each cushion straight, but along the {name} of "
                f"{dict(zip(free, size, strict=True))[name]:g} m, mouths and jaws are "
                f"{-left:.6g} m longer than the cushion. Give smaller mouths or jaws",
                at=("pockets",),
            )


def _check_holes(size: tuple[float, float], pockets: Pockets) -> None:
    """Check that no two holes overlap."""
    holes = [one.hole for one in place_pockets(*size, pockets)]
    for k, one in enumerate(holes):
        for other in holes[:k]:
            if math.dist(one.centre, other.centre) <= one.radius + other.radius:
                raise problem(
                    f"`pockets` must have holes apart from each other, but two of radius "
                    f"{one.radius:g} and {other.radius:g} m are "
                    f"{math.dist(one.centre, other.centre):.6g} m apart. Give smaller holes",
                    at=("pockets",),
                )
