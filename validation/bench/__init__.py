"""Measurements: our engine's speed, against targets and beside peers, its accuracy, and both."""

from ghostball.validation.bench.accuracy import AccuracyMeasurement, measure_accuracy
from ghostball.validation.bench.attribution import AttributionMeasurement, measure_attribution
from ghostball.validation.bench.measure import measure_targets
from ghostball.validation.bench.measurements import (
    Measurement,
    PeerRow,
    Row,
    ScalingMeasurement,
    TargetsMeasurement,
)
from ghostball.validation.bench.peer_engines import DEFAULT_PEERS, make_peers
from ghostball.validation.bench.precision import (
    DEFAULT_SCENES,
    PRECISION_ENGINES,
    QUICK_SCENES,
    PrecisionMeasurement,
    measure_precision,
)
from ghostball.validation.bench.racks import RACKS, RacksMeasurement, measure_racks
from ghostball.validation.bench.running import BenchError
from ghostball.validation.bench.scaling import TINY, WIDE, measure_scaling
from ghostball.validation.bench.sizes import FULL, QUICK
from ghostball.validation.bench.skips import SkipRow, SkipsMeasurement, many_balls, measure_skips
from ghostball.validation.bench.targets import TARGETS, Target, chosen_workloads
from ghostball.validation.bench.workloads import WORKLOADS

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
