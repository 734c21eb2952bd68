"""Set up the shot after a ball was pocketed, and continue a shot from a given time."""

from ghostball import Scene, Strike, find_scene, simulate

first = simulate(find_scene("pocket-draw"), record="events")  # the object ball goes in
strike = Strike(speed=1.0, direction=0.3)
second = Scene.after(first, changes={"cue": {"strike": strike}, "object": {"position": (0.6, 0.6)}})
print([ball.id for ball in Scene.after(first).balls], second.name)

again = simulate(first.at(0.5))
print(float(abs(again.rest_positions[0] - first.rest_positions[0]).max()) < 1e-12)
