"""Write a file of random strokes, in all directions: `python strokes.py COUNT FILE.parquet`."""

import sys

import numpy as np
import polars

count = int(sys.argv[1])
chance = np.random.default_rng(1)
strokes = {
    "speed": chance.uniform(1.0, 6.0, count),
    "direction": chance.uniform(-np.pi, np.pi, count),
    "offset_left": chance.uniform(-0.3, 0.3, count),
    "offset_up": chance.uniform(-0.3, 0.3, count),
}
polars.DataFrame(strokes).write_parquet(sys.argv[2])
