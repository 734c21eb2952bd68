"""How far a shot can be predicted: growth of rounding, its horizon, nearest other courses.

>>> from ghostball.validation.diagnose.predictability import predictability_of
>>> known = predictability_of(scene)
>>> known.horizon, known.nearest, known.fragile
"""

from ghostball.validation.diagnose.predictability.measure import predictability_of
from ghostball.validation.diagnose.predictability.prediction import (
    Predictability,
    PredictionStore,
    load_predictability,
    predictability_in,
)
from ghostball.validation.truth.bifurcations import bifurcations_of, nearest_of

__all__ = [
    "Predictability",
    "PredictionStore",
    "bifurcations_of",
    "load_predictability",
    "nearest_of",
    "predictability_in",
    "predictability_of",
]
