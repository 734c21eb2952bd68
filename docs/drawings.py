"""Drawings of the documentation, made by the code; each function returns SVG."""

from __future__ import annotations

import math

from ghostball.model import POOL_BALL_RADIUS, Disc, Hole, Segment, Table

_SCALE = 1500.0  # pixels a metre
_LEFT, _RIGHT, _BELOW, _ABOVE = 1.10, 1.44, 0.19, 0.09  # what is shown round a side pocket [m]


def side_pocket() -> str:
    """Return a drawing of a side pocket of a 9 ft table, to scale, with all dimensions."""
    table = Table.model_validate("wpa-9ft")
    assert table.pockets is not None
    pocket = table.pockets.side
    assert pocket is not None
    middle = table.length / 2.0

    def at(x: float, y: float) -> str:
        return f"{(x - _LEFT) * _SCALE:.1f},{(_ABOVE - y) * _SCALE:.1f}"

    def line(*points: tuple[float, float], look: str) -> str:
        return f'<polyline points="{" ".join(at(*point) for point in points)}" {look}/>'

    def circle(centre: tuple[float, float], radius: float, look: str) -> str:
        x, y = at(*centre).split(",")
        return f'<circle cx="{x}" cy="{y}" r="{radius * _SCALE:.1f}" {look}/>'

    def text(x: float, y: float, words: str, anchor: str = "middle") -> str:
        left, top = at(x, y).split(",")
        return f'<text x="{left}" y="{top}" text-anchor="{anchor}">{words}</text>'

    rubber = 'fill="none" stroke="#2f5d4a" stroke-width="4"'
    thin = 'fill="none" stroke="#888" stroke-width="1"'
    dashed = f'{thin} stroke-dasharray="4 3"'
    parts = []
    near = [one for one in table.obstacles if _is_near(one, middle)]
    for one in near:
        if isinstance(one, Hole):
            parts.append(circle(one.centre, one.radius, 'fill="#444" fill-opacity="0.35"'))
            edge = one.centre[1] + one.radius
            parts += [line((middle, 0.0), (middle, edge), look=thin)]
            parts += [text(middle + 0.004, edge + 0.0005, "depth", "start")]
            way = (middle + one.radius, one.centre[1])
            parts += [line(one.centre, way, look=thin)]
            parts += [text(middle + one.radius / 2.0, one.centre[1] + 0.004, "radius")]
        elif isinstance(one, Disc):
            parts.append(circle(one.centre, one.radius, dashed))
        else:
            parts.append(line(one.start, one.end, look=rubber))
    half = pocket.mouth / 2.0
    parts += [line((middle - half, 0.0), (middle - half, 0.03), look=dashed)]
    parts += [line((middle + half, 0.0), (middle + half, 0.03), look=dashed)]
    parts += [line((middle - half, 0.025), (middle + half, 0.025), look=thin)]
    parts += [text(middle, 0.029, f"mouth {1e3 * pocket.mouth:.1f} mm")]
    parts += [text(middle - half - 0.012, -0.03, f"angle {math.degrees(pocket.angle):.0f}°", "end")]
    parts += [text(middle + half + 0.02, -0.02, "jaw_radius", "start")]
    ball = (1.17, 0.05)
    parts += [circle(ball, POOL_BALL_RADIUS, thin), text(*ball, "a ball")]
    width, height = (_RIGHT - _LEFT) * _SCALE, (_ABOVE + _BELOW) * _SCALE
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" '
        f'style="max-width: {width:.0f}px; width: 100%" font-family="sans-serif" font-size="13" '
        f'fill="#777" role="img" aria-label="A side pocket to scale">{"".join(parts)}</svg>'
    )


def _is_near(one: Segment | Disc | Hole, middle: float) -> bool:
    """Return True if an obstacle belongs to the pocket in the middle of the bottom cushion."""
    place = one.start if isinstance(one, Segment) else one.centre
    end = one.end if isinstance(one, Segment) else one.centre
    return max(place[1], end[1]) < 0.01 and (
        abs(place[0] - middle) < 0.1 or abs(end[0] - middle) < 0.1
    )
