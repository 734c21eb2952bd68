"""Measurements: our engine's speed, against targets and beside peers, its accuracy, and both."""

from validation.bench.accuracy import AccuracyMeasurement, measure_accuracy
from validation.bench.attribution import AttributionMeasurement, measure_attribution
from validation.bench.measure import measure_targets
from validation.bench.measurements import (
    Measurement,
    PeerRow,
    Row,
    ScalingMeasurement,
    TargetsMeasurement,
)
from validation.bench.peer_engines import DEFAULT_PEERS, make_peers
from validation.bench.precision import (
    DEFAULT_SCENES,
    PRECISION_ENGINES,
    QUICK_SCENES,
    PrecisionMeasurement,
    measure_precision,
)
from validation.bench.racks import RACKS, RacksMeasurement, measure_racks
from validation.bench.running import BenchError
from validation.bench.scaling import TINY, WIDE, measure_scaling
from validation.bench.sizes import FULL, QUICK
from validation.bench.skips import SkipRow, SkipsMeasurement, many_balls, measure_skips
from validation.bench.targets import TARGETS, Target, chosen_workloads
from validation.bench.workloads import WORKLOADS

__all__ = [
    "DEFAULT_PEERS",
    "DEFAULT_SCENES",
    "FULL",
    "PRECISION_ENGINES",
    "QUICK",
    "QUICK_SCENES",
    "RACKS",
    "TARGETS",
    "TINY",
    "WIDE",
    "WORKLOADS",
    "AccuracyMeasurement",
    "AttributionMeasurement",
    "BenchError",
    "Measurement",
    "PeerRow",
    "PrecisionMeasurement",
    "RacksMeasurement",
    "Row",
    "ScalingMeasurement",
    "SkipRow",
    "SkipsMeasurement",
    "Target",
    "TargetsMeasurement",
    "chosen_workloads",
    "make_peers",
    "many_balls",
    "measure_accuracy",
    "measure_attribution",
    "measure_precision",
    "measure_racks",
    "measure_scaling",
    "measure_skips",
    "measure_targets",
]
