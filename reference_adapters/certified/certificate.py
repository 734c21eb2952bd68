"""What is proved about a shot: events, instants and positions, each as an interval of rationals.

These types need no interval arithmetic: numbers are integers and powers of two.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ghostball.engine.errors import GhostballError
from ghostball.engine.result import EventKind
from ghostball.engine.scene import CUSHIONS

Ending = Literal[
    "proved", "ambiguous", "sustained contact", "precision cap", "event limit", "time limit"
]
"""Why a certificate ends where it does; only a "proved" one reaches the end of the shot."""

ENDINGS: tuple[Ending, ...] = (
    "proved",
    "ambiguous",
    "sustained contact",
    "precision cap",
    "event limit",
    "time limit",
)

SCHEMA = 1
"""Version of the JSON form."""


@dataclass(frozen=True)
class Enclosure:
    """A closed interval that holds a real number: middle and radius, each m 2^e, exactly."""

    mid_mantissa: int
    mid_exponent: int
    rad_mantissa: int = 0
    rad_exponent: int = 0

    @property
    def mid(self) -> Fraction:
        """The middle."""
        return _scaled(self.mid_mantissa, self.mid_exponent)

    @property
    def rad(self) -> Fraction:
        """Half the width, never negative."""
        return _scaled(self.rad_mantissa, self.rad_exponent)

    @property
    def lower(self) -> Fraction:
        """The lower end."""
        return self.mid - self.rad

    @property
    def upper(self) -> Fraction:
        """The upper end."""
        return self.mid + self.rad

    @property
    def width(self) -> float:
        """Upper end less lower end, to double precision."""
        return float(2 * self.rad)

    def __float__(self) -> float:
        """Return the double nearest to the middle."""
        return float(self.mid)

    def contains(self, value: Fraction | float) -> bool:
        """Whether the interval holds a rational number; a float is the rational that it is."""
        exact = Fraction(value)
        return self.lower <= exact <= self.upper

    def encloses(self, other: Enclosure) -> bool:
        """Whether the other interval lies within this one."""
        return self.lower <= other.lower and other.upper <= self.upper

    def to_text(self) -> str:
        """Return the four integers in hexadecimal, "mp+-e r p+-e": exact, and read by `parse`."""
        return (
            f"{self.mid_mantissa:x}p{self.mid_exponent:x} "
            f"{self.rad_mantissa:x}p{self.rad_exponent:x}"
        )

    @classmethod
    def parse(cls, text: str) -> Enclosure:
        """Read what `to_text` wrote."""
        mid, rad = text.split(" ")
        mantissa, exponent = mid.split("p")
        rad_mantissa, rad_exponent = rad.split("p")
        return cls(
            int(mantissa, 16), int(exponent, 16), int(rad_mantissa, 16), int(rad_exponent, 16)
        )


def _scaled(mantissa: int, exponent: int) -> Fraction:
    if exponent >= 0:
        return Fraction(mantissa << exponent)
    return Fraction(mantissa, 1 << -exponent)


@dataclass(frozen=True)
class Choice:
    """An event that may come next: its kind, and the indices as in an event of a `Result`."""

    kind: EventKind
    a: int
    b: int

    def describe(self, ids: tuple[str, ...]) -> str:
        """Return the event with the names of its balls."""
        first = f'"{ids[self.a]}"'
        if self.kind is EventKind.BALL_BALL:
            return f'{self.kind.label} {first} with "{ids[self.b]}"'
        if self.kind is EventKind.BALL_CUSHION:
            return f"{self.kind.label} {first} with {CUSHIONS[self.b]}"
        return f"{self.kind.label} {first}"


@dataclass(frozen=True)
class CertifiedEvent:
    """One proved event.

    Attributes
    ----------
    kind : EventKind
    a, b : int
        As in an event of a `Result`.
    t : Enclosure [s]
    tie : bool
        Whether its place among the events next to it is a convention: an event without a ball in
        common with it may come at the very same instant, and either order has the same outcome.
    """

    kind: EventKind
    a: int
    b: int
    t: Enclosure
    tie: bool = False

    @property
    def key(self) -> tuple[EventKind, int, int]:
        """What happened to whom, without when."""
        return (self.kind, self.a, self.b)


@dataclass(frozen=True, eq=False)
class Certificate:
    """What is proved about a shot, up to where nothing more can be.

    Attributes
    ----------
    ending : str
        Why it ends; "proved" is the whole shot.
    reason : str
        Where it isn't the whole shot, what stopped it, with names and the time; else "".
    choices : tuple of Choice
        The events that couldn't be told apart, or the contact that is sustained; else empty.
    precision : int [bits]
        With which it was proved.
    events : tuple of CertifiedEvent, in order of time
    t_end : Enclosure [s]
        When the last ball rests and no longer spins, or `t_max`; or the last event proved.
    rested : bool
        Whether every ball rests at `t_end`.
    positions, velocities, spins : tuple of tuples of Enclosure [m], [m/s], [rad/s]
        Of each ball at `t_end`: (x, y), (vx, vy), (wx, wy, wz).
    seconds : float [s]
        What it took, all precisions together.
    knots : tuple of (k_i, 14) float64, or None
        The motion of each ball, as in `ExactTrajectory`, from the middles; where asked for.
    """

    ending: Ending
    reason: str
    choices: tuple[Choice, ...]
    precision: int
    events: tuple[CertifiedEvent, ...]
    t_end: Enclosure
    rested: bool
    positions: tuple[tuple[Enclosure, ...], ...]
    velocities: tuple[tuple[Enclosure, ...], ...]
    spins: tuple[tuple[Enclosure, ...], ...]
    seconds: float
    knots: tuple[NDArray[np.float64], ...] | None = None

    @property
    def proved(self) -> bool:
        """Whether the whole shot is proved."""
        return self.ending == "proved"

    @property
    def events_proved(self) -> int:
        """How many events are proved."""
        return len(self.events)

    @property
    def widest(self) -> float:
        """Width of the widest enclosure of a position at `t_end` [m]."""
        return max(e.width for position in self.positions for e in position)

    def to_json(self) -> str:
        """Return everything as one line of JSON, exactly; `from_json` reads it back."""
        data: dict[str, Any] = {
            "schema": SCHEMA,
            "ending": self.ending,
            "reason": self.reason,
            "choices": [[int(c.kind), c.a, c.b] for c in self.choices],
            "precision": self.precision,
            "events": [[int(e.kind), e.a, e.b, e.t.to_text(), e.tie] for e in self.events],
            "t_end": self.t_end.to_text(),
            "rested": self.rested,
            "seconds": self.seconds,
            "knots": None if self.knots is None else [k.tolist() for k in self.knots],
        }
        for name in ("positions", "velocities", "spins"):
            data[name] = [[e.to_text() for e in vector] for vector in getattr(self, name)]
        return json.dumps(data)

    @classmethod
    def from_json(cls, text: str) -> Certificate:
        """Read what `to_json` wrote.

        Raises
        ------
        GhostballError
            Where the text isn't a certificate of this version.
        """
        try:
            data = json.loads(text)
            if data["schema"] != SCHEMA or data["ending"] not in ENDINGS:
                raise ValueError("another schema")
            vectors = {
                name: tuple(tuple(map(Enclosure.parse, vector)) for vector in data[name])
                for name in ("positions", "velocities", "spins")
            }
            knots = data["knots"]
            return cls(
                ending=data["ending"],
                reason=str(data["reason"]),
                choices=tuple(Choice(EventKind(k), a, b) for k, a, b in data["choices"]),
                precision=int(data["precision"]),
                events=tuple(
                    CertifiedEvent(EventKind(k), a, b, Enclosure.parse(t), bool(tie))
                    for k, a, b, t, tie in data["events"]
                ),
                t_end=Enclosure.parse(data["t_end"]),
                rested=bool(data["rested"]),
                seconds=float(data["seconds"]),
                knots=None
                if knots is None
                else tuple(np.array(k, dtype=np.float64).reshape(-1, 14) for k in knots),
                **vectors,
            )
        except (ValueError, KeyError, TypeError) as error:
            raise GhostballError(
                f"a certificate must be JSON of schema {SCHEMA}, as `to_json` writes it: "
                f"{type(error).__name__}: {error}. Compute it anew"
            ) from None
