"""What `ghostball doctor` finds: all there, an engine that is missing, one that is broken."""

import pytest

from ghostball.validation import scene_names


@pytest.mark.usefixtures("without_pybullet")
def test_a_missing_optional_engine_is_listed_and_breaks_nothing(cli, tmp_path, monkeypatch):
    listed = cli("engines")
    assert listed.exit_code == 0
    assert "pybullet" in listed.stdout.partition("Not here: ")[2].partition(".")[0]
    assert "pybullet isn't installed" in cli("engines", "pybullet").stdout
    examined = cli("doctor")
    assert "pip install pybullet" in " ".join(examined.stdout.split())
    assert examined.exit_code == 0, examined.output
    monkeypatch.setattr("ghostball.cli.measure.validate.DEFAULT_ENGINES", ("ghostball", "pybullet"))
    out = tmp_path / "out"
    validated = cli("validate", "stop", "--out", out, "--format", "junit")
    assert validated.exit_code == 0, validated.output
    assert "cases without their engine here: 1" in validated.stderr
    assert "unavailable here" in (out / "report.html").read_text()
    assert "pybullet isn't installed" in validated.stdout
    assert "unavailable" in cli("report", out, "--format", "markdown").stdout


def test_a_broken_foreign_engine_is_named_and_hides_no_other(cli, tmp_path, monkeypatch):
    metadata = tmp_path / "broken_engine-1.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: broken-engine\nVersion: 1\n")
    (metadata / "entry_points.txt").write_text("[ghostball.engines]\nbroken = no_such_module:X\n")
    monkeypatch.syspath_prepend(tmp_path)
    listed = cli("engines")
    assert listed.exit_code == 0
    (row,) = (line for line in listed.stdout.splitlines() if line.split()[:1] == ["broken"])
    assert row.split()[1] == "no"
    why = cli("engines", "broken", "ghostball").stdout
    assert "broken  unavailable" in why
    assert "no_such_module" in why
    examined = cli("doctor")
    assert examined.exit_code == 1
    assert "Something is broken" in examined.stderr


def test_doctor_names_versions_kernels_engines_and_scenes(cli):
    result = cli("doctor")
    assert result.exit_code == 0, result.output
    for part in ("python", "numpy", "kernels", "engine ghostball", f"{len(scene_names())} shipped"):
        assert part in result.stdout
