"""The chance that a cut shot pockets its ball, if the aim has a random error."""

import numpy as np

from ghostball import Ball, Physics, Scene, Table, simulate_starts

balls = (Ball(id="cue", position=(1.20, 0.635)), Ball(id="object", position=(1.80, 0.9)))
table = Table.model_validate("wpa-9ft")
scene = Scene(name="cut", table=table, balls=balls, physics=Physics(preset="pool"))

shots, aim = 10_000, np.radians(23.7)
angles = aim + np.radians(0.1) * np.random.default_rng(1).standard_normal(shots)
velocities = np.zeros((shots, 2, 2))
velocities[:, 0] = 3.0 * np.stack((np.cos(angles), np.sin(angles)), axis=1)

batch = simulate_starts(scene, velocities=velocities)
made, scratched = batch.pocketed[:, 1] == 3, batch.pocketed[:, 0] >= 0
print(f"{np.mean(made):.1%} made, {np.mean(made & scratched):.1%} made and scratched")
print(f"{np.mean(batch.first_contact[:, 0] == 1):.1%} hit the object ball first")
batch.to_frame().write_parquet("shots.parquet")
