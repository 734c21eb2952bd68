"""What is known of where a difference comes from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ghostball.validation.diagnose.attribution._backward import BackwardError
from ghostball.validation.truth.known_shot import KnownBy

Outcome = Literal["attributed", "not told", "no step", "not compared"]
"""Whether a difference could be divided.

"not told": its runs don't say how, "no step": the engine has none that could be shortened.
"""


@dataclass(frozen=True)
class Part:
    """One part of a difference.

    Attributes
    ----------
    size : float [m]
        Of the ball on which it is largest.
    uncertainty : float [m]
        By how much the size may be off: a bound, see `zero_step_of`.
    share : float [1]
        Its part of the difference: its projection on it, over all balls, over the difference. The
        shares of model and discretisation add up to 1; negative is a part that hides another one.
    """

    size: float
    uncertainty: float
    share: float

    @property
    def told_from_zero(self) -> bool:
        """Whether the part is surely there."""
        return self.size > self.uncertainty


@dataclass(frozen=True)
class Better:
    """The same engine with one setting changed, and how it played the shot.

    Attributes
    ----------
    setting : str
    value : float or str
        A step [s], or a mode.
    difference : float [m]
        Largest distance of a ball from the truth, at the same instant.
    """

    setting: str
    value: float | str
    difference: float


@dataclass(frozen=True)
class Attribution:
    """Where the difference of one engine in one scene comes from.

    Attributes
    ----------
    scene, label, engine : str
        As in a `CaseRecord`.
    outcome : Outcome
    reason : str
        Where it could not be divided, why; else "".
    truth : "certified", "closed form" or "our engine"
        What it is the difference from.
    instant : float or None [s]
        When the balls were compared; None is at the end.
    until : str
        Why not at the end; else "".
    difference : float or None [m]
        Largest distance of a ball from the truth.
    model : Part or None
        What is left at zero step: physics that the engine lacks or has otherwise.
    discretisation : Part or None
        What goes away as the step goes to zero.
    rounding : float or None [m]
        By how much an ulp of the input moves a ball in this engine: what the other parts can't be
        told from.
    approximations : tuple of str
        What of this scene the engine says that it represents only approximately.
    step : float or None [s]
        The engine's step, where the ladder begins.
    finest : float or None [s]
        The step where it ends.
    runs : int
        How many runs the ladder has.
    better : tuple of Better
        How else the engine plays this shot, as measured: with the finest step, and with a mode that
        lands its steps on contacts, where it has one.
    backward : BackwardError or None
    no_backward : str
        Why there is none; else "".
    """

    scene: str
    label: str
    engine: str
    outcome: Outcome
    truth: KnownBy
    reason: str = ""
    instant: float | None = None
    until: str = ""
    difference: float | None = None
    model: Part | None = None
    discretisation: Part | None = None
    rounding: float | None = None
    approximations: tuple[str, ...] = ()
    step: float | None = None
    finest: float | None = None
    runs: int = 0
    better: tuple[Better, ...] = ()
    backward: BackwardError | None = None
    no_backward: str = ""
