"""What README says is true: its program runs, its figures are those of a stored measurement."""

import json
import re
from pathlib import Path

import pytest

from engine import Scene, Status, simulate

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_program_runs(capsys):
    program = re.search(r"```python\n(.*?)```", README, re.DOTALL)[1]
    assert len(program.splitlines()) <= 10
    names = {}
    exec(compile(program, "README.md", "exec"), names)
    assert "ball-ball" in capsys.readouterr().out
    difference = abs(names["other"].rest_positions - names["exact"].rest_positions).max()
    assert 0.5e-3 < difference < 2e-3  # "a millimetre"


def test_the_scene_is_one():
    lines = re.search(r"( {4}schema = 1\n(?: {4}.*\n)*)", README)[1]
    scene = Scene.loads("".join(line[4:] for line in lines.splitlines(keepends=True)))
    assert simulate(scene).status is Status.REST


def test_it_is_short_and_its_links_lead_somewhere():
    assert len(README.splitlines()) < 100
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        assert (ROOT / target).exists(), target


@pytest.mark.parametrize(
    ("scene", "pattern"),
    [
        ("break-16@8", r"at 8 m/s takes our engine ([\d.]+) ms"),
        ("break-16", r"at 4 m/s ([\d.]+) ms"),
        ("galperin-3", r"3141 collisions take ([\d.]+) ms"),
    ],
)
def test_times_are_those_measured(scene, pattern):
    """Rounded to two digits; a new measurement that is not carried over to README fails here."""
    said = float(re.search(pattern, re.sub(r"\s+", " ", README))[1])
    stored = json.loads(
        (ROOT / "benchmarks/results/amd-epyc-2-cores/engine_break.json").read_text()
    )
    (row,) = (row for row in stored["rows"] if row["scene"] == scene)
    assert said == float(f"{row['wall_time_us']['median'] / 1000:.2g}")
