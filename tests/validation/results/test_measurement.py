"""Fails where a measurement doesn't read back, is half written, or another file is taken for it."""

from typing import Literal

import pytest

from ghostball.validation.results.measurement import Measurement, MeasurementError, make_folder


class Counted(Measurement):
    kind: Literal["counted"] = "counted"
    rows: tuple[float, ...]
    names: tuple[str, ...] = ()


class Timed(Measurement):
    kind: Literal["timed"] = "timed"


MEASURED = Counted(rows=(1e-5, 2e-5))


def test_it_reads_back_and_has_a_row_on_a_line(tmp_path):
    path = MEASURED.save(tmp_path / "made")
    assert Counted.load(path) == MEASURED
    assert path.name == "counted.json"
    assert '"rows": [\n    1e-05,\n    2e-05\n  ],\n  "names": []' in path.read_text()


def test_another_kind_or_damage_is_refused_by_name(tmp_path):
    path = MEASURED.save(tmp_path)
    with pytest.raises(MeasurementError, match=r"counted.json: `kind`"):
        Timed.load(path)
    path.write_text(path.read_text()[:-20])
    with pytest.raises(MeasurementError, match="Invalid JSON"):
        Counted.load(path)
    with pytest.raises(MeasurementError, match="can't read"):
        Counted.load(tmp_path / "nowhere.json")


def test_a_folder_that_cannot_be_written_is_an_error(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(MeasurementError, match="can't write the measurement"):
        MEASURED.save(tmp_path / "file")
    with pytest.raises(MeasurementError, match="can't make the folder"):
        make_folder(tmp_path / "file")
