"""`ghostball run`: output for a shot, and for an unsupported scene."""

from __future__ import annotations

import json
import math

import pytest

from ghostball.cli.measure import run
from ghostball.cli.measure.run import result_table
from ghostball.cli.shared.terminal import stdout
from ghostball.engine import simulate
from ghostball.model import Ball, Scene
from ghostball.reference_adapters import make_engine
from ghostball.validation.scenes.library import find_scene


def shown(scene: Scene) -> str:
    console = stdout()
    with console.capture() as caught:
        console.print(result_table(simulate(scene, record="events")))
    return caught.get()


def test_pocketed_balls_are_printed_with_their_pockets() -> None:
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


@pytest.mark.parametrize(("engine", "scenes"), [("ghostball", ["stop"]), ("pymunk", [])])
def test_only_our_engine_waits_for_our_kernels(cli, monkeypatch, engine, scenes):
    # A shot on another engine must not compile unused kernels.
    asked = []
    monkeypatch.setattr(run, "compile_first", lambda given, label: asked.append((given, label)))
    assert cli("run", "stop", "-e", engine).exit_code == 0
    ((given, label),) = asked
    assert ([scene.name for scene in given], label) == (scenes, engine)


def test_a_cue_stroke_is_printed_with_its_result() -> None:
    strike = {"speed": 3, "direction": 0.5, "elevation": 0.1, "offset_left": -0.2}
    ball = {"id": "cue", "position": (0.6, 0.6), "strike": strike}
    scene = Scene.model_validate({"name": "struck", "physics": {"preset": "pool"}, "balls": [ball]})
    (told,) = simulate(scene).to_dict()["strikes"]
    degrees = math.degrees(told["squirt_angle"])
    assert degrees > 0.5
    text = " ".join(shown(scene).split())
    for part in (
        "strike of cue",
        "3 m/s in the direction 28.648 degrees (0.5 rad)",
        "elevated by 5.7296 degrees (0.1 rad)",
        "hit 0.2 radii to the right",
        f"{math.hypot(*told['velocity']):.6g} m/s",
        f"squirt {degrees:.4g} degrees to the left (end-mass)",
        f"{-told['tip_velocity'][2]:.4g} m/s into the table",
        f"the cue then moves at {told['cue_speed']:.4g} m/s",
    ):
        assert part in text, part
    still = Scene(name="still", balls=[Ball(id="cue", position=(0.6, 0.6))])
    assert "strike" not in shown(still)


def test_a_hash_that_is_expected_is_compared_in_one_line(cli) -> None:
    found = simulate(find_scene("stop"), record="events").to_dict()["hash"]
    assert found in " ".join(shown(find_scene("stop")).split())
    same = cli("run", "stop", "--expect-hash", found.upper())
    assert (same.exit_code, same.stderr) == (0, "")
    other = cli("run", "stop", "--expect-hash", "0" * 64)
    assert other.exit_code == 1
    assert other.stderr == (f"hash differs: stop on ghostball has {found}, expected {'0' * 64}\n")


def test_run_shows_rest_positions_counts_energy_work_and_time(cli):
    result = cli("run", "half-ball-cut")
    assert result.exit_code == 0, result.output
    expected = make_engine("ghostball").simulate(find_scene("half-ball-cut"))
    for x, y, _ in expected.rest_positions:
        assert f"{x:.9f}" in result.stdout
        assert f"{y:.9f}" in result.stdout
    for part in ("x [m]", "ball-ball 1, ball-cushion 0", "J at the start", "events 3", "ms"):
        assert part in result.stdout


def test_json_reads_back_to_the_same_bits(cli):
    result = cli("run", "half-ball-cut", "--format=json", "--record", "events")
    assert result.exit_code == 0, result.output
    printed = json.loads(result.stdout)
    expected = make_engine("ghostball").simulate(find_scene("half-ball-cut"), record="events")
    assert printed["rest_positions"] == expected.rest_positions.tolist()
    assert printed["rest_time"] == expected.rest_time
    assert [event["t"] for event in printed["events"]] == expected.events["t"].tolist()
    assert list(printed) == list(expected.to_dict())
    assert result.stdout.count("\n") == 1


def test_plot_writes_a_picture(cli, tmp_path):
    picture = tmp_path / "shot.png"
    result = cli("run", "stop", "--plot", picture)
    assert result.exit_code == 0, result.output
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert f"picture: {picture}" in result.stdout


def test_a_film_is_announced_as_a_film(cli, tmp_path, monkeypatch):
    monkeypatch.setattr("ghostball.reports.plot.LONGEST", 0.2)
    film = tmp_path / "shot.gif"
    result = cli("run", "stop", "--plot", film)
    assert result.exit_code == 0, result.output
    assert film.read_bytes().startswith(b"GIF")
    assert f"film: {film}" in result.stdout
