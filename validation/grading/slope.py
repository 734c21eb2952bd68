"""Numbers that carry their derivative: forward automatic differentiation."""

from __future__ import annotations

import math
from typing import Any

from ghostball.model.arrays import FloatArray


class Slope:
    """A number and its derivative; impact laws accept it in place of a number."""

    __slots__ = ("slope", "value")

    def __init__(self, value: float, slope: FloatArray) -> None:
        self.value = value
        self.slope = slope

    def is_zero(self) -> bool:
        """Return True if the number is 0, whatever its derivative."""
        return self.value == 0.0

    def __float__(self) -> float:
        return self.value

    def __neg__(self) -> Slope:
        return Slope(-self.value, -self.slope)

    def __abs__(self) -> Slope:
        return -self if self.value < 0.0 else self

    def __add__(self, other: Any) -> Slope:
        if isinstance(other, Slope):
            return Slope(self.value + other.value, self.slope + other.slope)
        return Slope(self.value + float(other), self.slope)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Slope:
        return self.__add__(-other)

    def __rsub__(self, other: Any) -> Slope:
        return (-self).__add__(other)

    def __mul__(self, other: Any) -> Slope:
        if isinstance(other, Slope):
            return Slope(
                self.value * other.value, self.value * other.slope + other.value * self.slope
            )
        factor = float(other)
        return Slope(self.value * factor, self.slope * factor)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Slope:
        if isinstance(other, Slope):
            ratio = self.value / other.value
            return Slope(ratio, (self.slope - ratio * other.slope) / other.value)
        return self * (1.0 / float(other))

    def __rtruediv__(self, other: Any) -> Slope:
        ratio = float(other) / self.value
        return Slope(ratio, self.slope * (-ratio / self.value))

    def sqrt(self) -> Slope:
        """Return the square root."""
        root = math.sqrt(self.value)
        return Slope(root, self.slope * (0.5 / root))

    def exp(self) -> Slope:
        """Return the exponential function."""
        power = math.exp(self.value)
        return Slope(power, self.slope * power)

    def __lt__(self, other: Any) -> bool:
        return self.value < float(other)

    def __le__(self, other: Any) -> bool:
        return self.value <= float(other)

    def __gt__(self, other: Any) -> bool:
        return self.value > float(other)

    def __ge__(self, other: Any) -> bool:
        return self.value >= float(other)
