"""What `ghostball run` shows of a shot."""

from __future__ import annotations

from ghostball.cli.measure.run import result_table
from ghostball.cli.shared.terminal import stdout
from ghostball.engine import simulate
from ghostball.model import Ball, Scene


def shown(scene: Scene) -> str:
    console = stdout()
    with console.capture() as caught:
        console.print(result_table(simulate(scene, record="events")))
    return caught.get()


def test_what_was_pocketed_is_named_by_ball_and_pocket() -> None:
    balls = [
        Ball(id="one", position=(1.27, 0.6), velocity=(0.0, -1.5)),
        Ball(id="two", position=(0.5, 0.5), velocity=(-2.0, -2.0)),
        Ball(id="three", position=(2.0, 0.5)),
    ]
    scene = Scene.model_validate({"name": "three", "table": "wpa-9ft", "balls": balls})
    (line,) = (line for line in shown(scene).splitlines() if "pocketed" in line)
    assert line.split(maxsplit=1)[1].strip() == "two (bottom-left), one (bottom)"
    plain = Scene.model_validate({"name": "three", "table": "carom-10ft", "balls": balls})
    assert "pocketed" not in shown(plain)
