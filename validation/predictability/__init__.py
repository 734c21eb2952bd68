"""How far a shot can be predicted: growth of rounding, its horizon, nearest other courses.

>>> from validation.predictability import predictability_of
>>> known = predictability_of(scene)
>>> known.horizon, known.nearest, known.fragile
"""

from validation.predictability.bifurcations import Bifurcation, bifurcations_of, nearest_of
from validation.predictability.measure import predictability_of
from validation.predictability.records import Predictability, Separation
from validation.predictability.store import (
    load_predictability,
    predictability_in,
    save_predictability,
)

__all__ = [
    "Bifurcation",
    "Predictability",
    "Separation",
    "bifurcations_of",
    "load_predictability",
    "nearest_of",
    "predictability_in",
    "predictability_of",
    "save_predictability",
]
