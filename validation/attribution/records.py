"""What is known of where a difference comes from, as it is stored."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from pydantic import ConfigDict

from validation.attribution._backward import BackwardError
from validation.known_shot import KnownBy

SCHEMA: Final = 1
"""Version of these records and of their file; another one is refused."""

Outcome = Literal["attributed", "not converged", "no step", "not compared"]
"""Whether a difference could be divided. "no step": the engine has none to halve."""


@dataclass(frozen=True)
class Part:
    """One part of a difference.

    Attributes
    ----------
    size : float [m]
        Of the ball on which it is largest.
    uncertainty : float [m]
    share : float [1]
        Its part of the difference: its projection on it, over all balls, over the difference. The
        shares of model and discretisation add up to 1; negative is a part that hides another one.
    """

    size: float
    uncertainty: float
    share: float


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
    phases : tuple of int
        Start phases that were run at each level.
    flat : bool
        Whether the step made no difference; `discretisation` is then a bound, and without order.
    order, order_low, order_high : float or None [1]
        In which the difference falls with the step, as fitted, and its range.
    order_used : float or None [1]
        What the extrapolation used.
    backward : BackwardError or None
    no_backward : str
        Why there is none; else "".
    definition_hash, code_hash : str
        Hashes of the scene, and of the code as in `CaseRecord`.
    schema : int
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
    phases: tuple[int, ...] = ()
    flat: bool = False
    order: float | None = None
    order_low: float | None = None
    order_high: float | None = None
    order_used: float | None = None
    backward: BackwardError | None = None
    no_backward: str = ""
    definition_hash: str = ""
    code_hash: str = ""
    schema: int = SCHEMA

    __pydantic_config__ = ConfigDict(extra="forbid")
