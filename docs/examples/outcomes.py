"""The chance that a cut shot pockets its ball, if the stroke has random errors."""

import numpy as np

from ghostball import Ball, Physics, Scene, Strokes, Table, simulate_starts

balls = (Ball(id="cue", position=(1.20, 0.635)), Ball(id="object", position=(1.80, 0.9)))
table = Table.model_validate("wpa-9ft")
scene = Scene(name="cut", table=table, balls=balls, physics=Physics(preset="pool"))

errors = {"speed": 0.1, "direction": np.radians(0.2), "offset_left": 0.02, "offset_up": 0.02}
strokes = Strokes(np.full(10_000, 2.5), np.radians(23.7), noise=errors, seed=1)
batch = simulate_starts(scene, strokes=strokes)

made, scratched = batch.pocketed[:, 1] == 3, batch.pocketed[:, 0] >= 0
print(f"{np.mean(made):.1%} made, {np.mean(made & scratched):.1%} made and scratched")
print(f"{np.mean(batch.first_contact[:, 0] == 1):.1%} hit the object ball first")
batch.to_frame().write_parquet("shots.parquet")
