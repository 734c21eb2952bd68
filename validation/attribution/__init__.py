"""Where a difference comes from: the engine's model, its step, rounding; and its backward error.

    >>> from validation.attribution import attribute
    >>> attribute(scene, make_engine("pymunk")).discretisation

difference = model + discretisation + rounding: what the engine's physics lacks, what goes away as
its step goes to zero, and what an ulp of the input does.
"""

from validation.attribution._attribute import attribute
from validation.attribution._backward import BackwardError, NoCueBallError, backward_error
from validation.attribution._extrapolation import (
    FEWEST_LEVELS,
    WHOLE_ORDERS,
    Extrapolation,
    extrapolate,
)
from validation.attribution._file import (
    ATTRIBUTIONS_FILE,
    read_attributions,
    write_attributions,
)
from validation.attribution._many import attribute_many, attribute_results, attributions_of
from validation.attribution._phases import begun_earlier
from validation.attribution._runs import Plan
from validation.attribution.records import Attribution, Part

__all__ = [
    "ATTRIBUTIONS_FILE",
    "FEWEST_LEVELS",
    "WHOLE_ORDERS",
    "Attribution",
    "BackwardError",
    "Extrapolation",
    "NoCueBallError",
    "Part",
    "Plan",
    "attribute",
    "attribute_many",
    "attribute_results",
    "attributions_of",
    "backward_error",
    "begun_earlier",
    "extrapolate",
    "read_attributions",
    "write_attributions",
]
