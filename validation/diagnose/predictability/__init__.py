"""How far a shot can be predicted: growth of rounding, and its horizon.

>>> from ghostball.validation.diagnose.predictability import predictability_of
>>> known = predictability_of(scene)
>>> known.horizon, known.ends
"""

from ghostball.validation.diagnose.predictability.measure import predictability_of
from ghostball.validation.diagnose.predictability.prediction import (
    Predictability,
    PredictionStore,
    load_predictability,
    predictability_in,
)

__all__ = [
    "Predictability",
    "PredictionStore",
    "load_predictability",
    "predictability_in",
    "predictability_of",
]
