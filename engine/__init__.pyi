from .batch import STATUSES as STATUSES, Batch as Batch, simulate_many as simulate_many
from .needed_kernels import warm_up as warm_up
from .shot import simulate as simulate
from .starts import simulate_starts as simulate_starts
from .strokes import DrawnStrokes as DrawnStrokes, Strokes as Strokes
from .sweep import simulate_sweep as simulate_sweep
