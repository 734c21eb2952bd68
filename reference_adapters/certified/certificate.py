"""The proved facts about a shot: events, times and positions, each as an interval of rationals.

These types need no interval arithmetic: numbers are integers and powers of two.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal

import numpy as np

from ghostball.engine.tangents import tangents_of
from ghostball.model import EventKind, ExactTrajectory, Scene, partner_name
from ghostball.model.arrays import FloatArray
from ghostball.model.events import OBSTACLE_KINDS
from ghostball.model.trajectory import segment

Ending = Literal[
    "proved", "ambiguous", "sustained contact", "precision cap", "event limit", "time limit"
]
"""Why a certificate ends; only a "proved" one reaches the end of the shot."""

_VECTORS = ("positions", "velocities", "spins")
"""The fields of a certificate that have a vector for each ball."""

_RISES = ("rise", "up_speed", "fall")
"""Additional columns of segments in airborne scenes."""


def segment_columns(powers: int = 2, *, lifts: bool = False) -> tuple[str, ...]:
    """Return the names of the columns of segments; see `ExactTrajectory`.

    `powers`: highest power of the time in the displacement of a ball.
    `lifts`: whether balls may be in the air.
    """
    names = segment.NAMES + (_RISES if lifts else ())
    if powers == 2:
        return names
    further = [f"{name}{n}" for n in range(2, powers + 1) for name in ("x", "y", "z", "wx", "wy")]
    return (*names, *further)


@dataclass(frozen=True)
class Enclosure:
    """A closed interval that contains a real number: middle and radius, each exactly m 2^e."""

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
        """Upper end minus lower end, in double precision."""
        return float(2 * self.rad)

    def __float__(self) -> float:
        """Return the double nearest to the middle."""
        return float(self.mid)

    def contains(self, value: Fraction | float) -> bool:
        """Return whether the interval contains a number; a float counts with its exact value."""
        exact = Fraction(value)
        return self.lower <= exact <= self.upper

    def to_text(self) -> str:
        """Return the four integers in hexadecimal, "mp+-e r p+-e": exact, to be read by `parse`."""
        return (
            f"{self.mid_mantissa:x}p{self.mid_exponent:x} "
            f"{self.rad_mantissa:x}p{self.rad_exponent:x}"
        )

    @classmethod
    def parse(cls, text: str) -> Enclosure:
        """Read the output of `to_text`."""
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
    """A possible next event: its kind and indices, as in an event of a `Result`."""

    kind: EventKind
    a: int
    b: int

    @property
    def balls(self) -> tuple[int, ...]:
        """Indices of the balls of the event."""
        return (self.a, self.b) if self.kind is EventKind.BALL_BALL else (self.a,)

    def describe(self, ids: tuple[str, ...]) -> str:
        """Return the event as text, with the names of its balls."""
        first = f'"{ids[self.a]}"'
        if self.kind is EventKind.BALL_BALL:
            return f'{self.kind.label} {first} with "{ids[self.b]}"'
        if self.kind in OBSTACLE_KINDS:
            return f"{self.kind.label} {first} with {partner_name(self.kind, self.b)}"
        return f"{self.kind.label} {first}"


@dataclass(frozen=True)
class CertifiedEvent:
    """A proved event.

    `a`, `b`: as in an event of a `Result`.
    `t`: time [s].
    `tie`: whether its place among the neighbouring events is a convention: an event without a
        common ball may happen at the same time, and either order has the same outcome; or the
        impacts act together.
    """

    kind: EventKind
    a: int
    b: int
    t: Enclosure
    tie: bool = False

    @property
    def key(self) -> tuple[EventKind, int, int]:
        """Kind and indices of the event, without its time."""
        return (self.kind, self.a, self.b)


@dataclass(frozen=True, eq=False)
class Certificate:
    """The proved facts about a shot, up to the time at which the proof ends.

    `ending`: why the proof ends; "proved" means that the whole shot is proved.
    `reason`: what stopped a partial proof, with names and the time; otherwise "".
    `choices`: the events that couldn't be ordered, or the resting contact; otherwise empty.
    `precision`: precision of the proof [bits].
    `t_end`: time at which the last ball rests and no longer spins, or `t_max`; or the time of the
        last proved event [s].
    `rested`: whether every ball rests at `t_end`.
    `positions`, `velocities`, `spins`: state of each ball at `t_end` [m], [m/s], [rad/s]: (x, y),
        (vx, vy), (wx, wy, wz); with z and vz in airborne scenes.
    `seconds`: computing time for all precisions together [s].
    `segments`: the motion of each ball, as in `ExactTrajectory`, from the middles of the intervals,
        if requested.
    `columns`: names of the columns of `segments`, see `segment_columns`.
    `starts`: for each ball, the rows of its segments at which the shot starts or an event changes
        its motion. Rows in between are further pieces of the same motion's series.
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
    segments: tuple[FloatArray, ...] | None = None
    columns: tuple[str, ...] = ()
    starts: tuple[tuple[int, ...], ...] = ()

    def trajectory(self, scene: Scene) -> ExactTrajectory | None:
        """Return the proved motion of its scene; None if it wasn't requested."""
        if self.segments is None:
            return None
        return ExactTrajectory(
            scene.radii,
            self.segments,
            float(self.t_end),
            scene.spinning_friction_rates,
            lifts=self.lifts,
            tangents=tangents_of,
        )

    @property
    def lifts(self) -> bool:
        """Whether the motion contains the heights of balls."""
        return "rise" in self.columns

    @property
    def proved(self) -> bool:
        """Whether the whole shot is proved."""
        return self.ending == "proved"

    @property
    def events_proved(self) -> int:
        """Number of proved events."""
        return len(self.events)

    def to_json(self) -> str:
        """Return everything as one line of JSON, exactly; `from_json` reads it."""
        data: dict[str, Any] = {
            "ending": self.ending,
            "reason": self.reason,
            "choices": [[int(c.kind), c.a, c.b] for c in self.choices],
            "precision": self.precision,
            "events": [[int(e.kind), e.a, e.b, e.t.to_text(), e.tie] for e in self.events],
            "t_end": self.t_end.to_text(),
            "rested": self.rested,
            "seconds": self.seconds,
            "segments": None,
        }
        if self.segments is not None:
            data["segments"] = {
                "columns": self.columns,
                "balls": [
                    {"shape": k.shape, "starts": starts, "numbers": k.ravel().tolist()}
                    for k, starts in zip(self.segments, self.starts, strict=True)
                ],
            }
        for name in _VECTORS:
            data[name] = [[e.to_text() for e in vector] for vector in getattr(self, name)]
        return json.dumps(data)

    @classmethod
    def from_json(cls, text: str) -> Certificate:
        """Read the output of `to_json`."""
        data = json.loads(text)
        vectors: dict[str, Any] = {
            name: tuple(tuple(map(Enclosure.parse, vector)) for vector in data[name])
            for name in _VECTORS
        }
        motion: dict[str, Any] = {}
        if (stored := data["segments"]) is not None:
            motion["columns"] = tuple(stored["columns"])
            motion["segments"] = tuple(
                np.array(one["numbers"], dtype=np.float64).reshape(one["shape"])
                for one in stored["balls"]
            )
            motion["starts"] = tuple(tuple(one["starts"]) for one in stored["balls"])
        return cls(
            ending=data["ending"],
            reason=data["reason"],
            choices=tuple(Choice(EventKind(k), a, b) for k, a, b in data["choices"]),
            precision=data["precision"],
            events=tuple(
                CertifiedEvent(EventKind(k), a, b, Enclosure.parse(t), tie)
                for k, a, b, t, tie in data["events"]
            ),
            t_end=Enclosure.parse(data["t_end"]),
            rested=data["rested"],
            seconds=data["seconds"],
            **vectors,
            **motion,
        )
