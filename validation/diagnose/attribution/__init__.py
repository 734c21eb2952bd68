"""Where a difference comes from: the engine's model, its step, rounding; and its backward error.

    >>> from ghostball.validation.diagnose.attribution import attribute
    >>> attribute(scene, make_engine("pymunk")).discretisation

difference = model + discretisation + rounding: what the engine's physics lacks, what goes away as
its step goes to zero, and what an ulp of the input does. Where the steps don't say how much is
which, no number is given.
"""

from ghostball.validation.diagnose.attribution._attribute import attribute
from ghostball.validation.diagnose.attribution._backward import (
    BackwardError,
    NoCueBallError,
    backward_error,
)
from ghostball.validation.diagnose.attribution._zero_step import (
    largest_distance,
)
from ghostball.validation.diagnose.attribution.attribution_record import Attribution, Better, Part

__all__ = [
    "Attribution",
    "BackwardError",
    "Better",
    "NoCueBallError",
    "Part",
    "attribute",
    "backward_error",
    "largest_distance",
]
