"""Flight in air at 30 digits: an independent oracle, by Taylor steps of fixed parts of v / a."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from mpmath import mp, mpf

DIGITS = 30
_ORDER, _PART = 40, mpf("0.1")
Vector = list[mpf]
Piece = tuple[mpf, mpf, list[Vector]]  # when it begins, how long it lasts, place by power


class Arc:
    """The path of a ball's centre, from `place` at `velocity`, at instants from 0 on."""

    def __init__(self, place: Sequence[float], velocity: Sequence[float], k: float, g: float):
        self._k, self._g = mpf(k), mpf(g)
        self._pieces: list[Piece] = []
        self._end = (mpf(0), [mpf(x) for x in place], [mpf(v) for v in velocity])

    def at(self, t: mpf) -> tuple[Vector, Vector]:
        """Return place and velocity at an instant [s]."""
        t = mpf(t)
        while self._end[0] <= t:
            self._step()
        begins, _, powers = next(p for p in self._pieces if p[0] <= t <= p[0] + p[1])
        return _value(powers, t - begins)

    def when(self, gap: Callable[[Vector], mpf], before: float, after: float) -> mpf:
        """Return the one instant between two at which a gap between places is 0 [s]."""
        low, high = mpf(before), mpf(after)
        sign = gap(self.at(low)[0]) > 0
        assert (gap(self.at(high)[0]) > 0) != sign
        for _ in range(4 * DIGITS):
            middle = (low + high) / 2
            if (gap(self.at(middle)[0]) > 0) == sign:
                low = middle
            else:
                high = middle
        return (low + high) / 2

    def _step(self) -> None:
        t, place, velocity = self._end
        v = [velocity]
        s = [mp.sqrt(sum(x * x for x in velocity))]
        for n in range(_ORDER):
            if n > 0:
                square = sum(x[a] * y[a] for x, y in zip(v, v[::-1], strict=True) for a in range(3))
                square -= sum(s[j] * s[n - j] for j in range(1, n))
                s.append(square / (2 * s[0]))
            drag = [sum(s[j] * v[n - j][a] for j in range(n + 1)) * self._k for a in range(3)]
            drag[2] += self._g if n == 0 else 0
            v.append([-one / (n + 1) for one in drag])
        lasts = _PART * s[0] / (self._g + self._k * s[0] ** 2)
        powers = [place, *([x / (n + 1) for x in one] for n, one in enumerate(v))]
        self._pieces.append((t, lasts, powers))
        self._end = (t + lasts, *_value(powers, lasts))


def _value(powers: list[Vector], s: mpf) -> tuple[Vector, Vector]:
    place = [sum(one[a] * s**n for n, one in enumerate(powers)) for a in range(3)]
    speed = [sum(n * one[a] * s ** (n - 1) for n, one in enumerate(powers) if n) for a in range(3)]
    return place, speed
