"""`python -m benchmarks precision`: what it prints, writes and refuses."""

import pytest
from typer.testing import CliRunner

from benchmarks import measurements
from benchmarks.__main__ import app
from benchmarks.precision.points import PrecisionMeasurement


def refused(result, *parts):
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    assert "Traceback" not in result.stderr
    assert all(part in result.stderr for part in parts), result.stderr
    return True


def precision(monkeypatch, *arguments):
    monkeypatch.setenv("COLUMNS", "200")
    return CliRunner().invoke(app, ["precision", *map(str, arguments)])


def test_precision_tables_what_is_reached_and_writes(monkeypatch, tmp_path):
    engines = ("ghostball", "paper-continuous", "pymunk:mode=landed")
    shot = ["half-ball-cut", *(f"-e{one}" for one in engines)]
    result = precision(monkeypatch, *shot, "--smoke", "--out", tmp_path)
    assert result.exit_code == 0, result.output
    assert "these times mean nothing" in result.stdout
    assert "half-ball-cut (closed form)" in result.stdout
    assert "to 1 mm" in result.stdout
    assert "not reached" in result.stdout
    kept = measurements.load(tmp_path / "precision.json", PrecisionMeasurement)
    assert kept.quick
    assert {point.engine for point in kept.points} == set(engines)


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["nosuch"], ['unknown scene or tag "nosuch"']),
        (["mathavan-cut"], ['"mathavan-cut" has no truth', "no closed form", "Leave it out"]),
        (["-e", "pymunk:dt=-1"], ["`dt` of engine `pymunk`", "-1"]),
        (["-e", "nosuch"], ["nosuch"]),
        (["-e", "ghostball", "-e", ""], ["name must be given"]),
        (["--repeats", "0"], ["--repeats"]),
        (["--store", "--smoke"], ["`--store`", "--smoke"]),
        (["--store", "-e", "ghostball"], ["`--store`", "--engine"]),
        (["--store", "half-ball-cut"], ["`--store`", "single scenes"]),
    ],
)
def test_bad_input_to_precision_is_refused(monkeypatch, arguments, parts):
    assert refused(precision(monkeypatch, *arguments), *parts)
