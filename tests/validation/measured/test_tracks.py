"""Files of tracks: valid files are read; errors name the file, the line and the expectation."""

from __future__ import annotations

import numpy as np
import pytest

from ghostball.validation.measured.tracks import Surface, TracksError, read_tracks

SURFACE = Surface(2.84, 1.42, 0.03075)
GOOD = "# a comment\nshot,ball,t,x,y\n1,cue,0.00,0.5,0.5\n1,cue,0.02,0.52,0.5\n2,cue,0.0,1.0,1.0\n"


def read(tmp_path, text, columns=None, **options):
    path = tmp_path / "tracks.csv"
    path.write_text(text, encoding="utf-8")
    return read_tracks(path, SURFACE, columns, **options)


def test_what_is_written_is_read(tmp_path):
    shots = read(tmp_path, GOOD)
    assert {shot: list(balls) for shot, balls in shots.items()} == {"1": ["cue"], "2": ["cue"]}
    track = shots["1"]["cue"]
    assert track.times.tolist() == [0.0, 0.02]
    assert track.at(np.array([0.01])).tolist() == [[0.51, 0.5]]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "expected the header shot,ball,t,x,y, found an empty file"),
        ("shot,ball,t,x,y\n", "expected samples below the header, found none"),
        ("shot,ball,time,x,y\n", "tracks.csv:1: expected the header shot,ball,t,x,y, found"),
        (GOOD + "2,cue,0.1,1.0\n", "tracks.csv:6: expected 5 fields, found 4"),
        (GOOD + "2,cue,0.1,1.0,left\n", "tracks.csv:6: expected numbers as t, x and y"),
        (GOOD + "2,cue,0.1,nan,1\n", "tracks.csv:6: expected finite numbers as t, x and y"),
        (GOOD + "2,cue,0.1,2.95,1\n", "expected x between 0 and 2.84 m, the playing surface"),
        (GOOD + "2,cue,0.1,100,51\n", "found 100; are the units centimetres or millimetres?"),
        (
            GOOD + "2,cue,-0.1,1,1\n",
            "expected a time after 0 s, the time of ball cue's previous sample",
        ),
        (GOOD + "2,cue,0.02,2,1\n", "found a distance of 1 m: were two balls swapped?"),
    ],
)
def test_what_is_wrong_is_named_in_one_line(tmp_path, text, said):
    with pytest.raises(TracksError) as refused:
        read(tmp_path, text)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)
    assert "tracks.csv" in str(refused.value)


OTHER = (
    "frame,time,id,px,py,shot\n"
    "0,0.00,cue,-0.92,-0.21,1\n"
    "1,0.02,cue,-0.90,-0.21,1\n"
    "0,0.00,cue,-0.42,0.29,2\n"
)
NAMES = {"t": "time", "ball": "id", "x": "px", "y": "py"}


def test_other_columns_and_a_centred_origin_give_the_same_tracks(tmp_path):
    expected, found = read(tmp_path, GOOD), read(tmp_path, OTHER, NAMES, centred=True)
    for shot in ("1", "2"):
        one, other = expected[shot]["cue"], found[shot]["cue"]
        assert one.times.tolist() == other.times.tolist()
        np.testing.assert_allclose(one.positions, other.positions, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize(
    ("text", "columns", "said"),
    [
        (
            OTHER,
            NAMES | {"x": "no"},
            "tracks.csv:1: expected columns shot, id, time, no, py, found",
        ),
        (OTHER.replace("frame", "px"), NAMES, "tracks.csv:1: expected columns"),
        (OTHER.replace("-", "") + "1,0.0,cue\n", NAMES, "tracks.csv:5: expected 6 fields, found 3"),
        (OTHER, NAMES, "expected x between 0 and 2.84 m, .*the centre \\(--origin centre\\)"),
    ],
)
def test_wrong_columns_are_named(tmp_path, text, columns, said):
    with pytest.raises(TracksError, match=said):
        read(tmp_path, text, columns)


def test_a_centred_table_has_its_own_limits(tmp_path):
    with pytest.raises(TracksError, match=r"expected x between -1.42 and 1.42 m"):
        read(tmp_path, "shot,ball,t,x,y\n2,cue,0.0,1.6,0.5\n", {}, centred=True)


@pytest.mark.parametrize("place", ["shot", "x"])
def test_a_huge_field_is_refused_in_one_short_line(tmp_path, place):
    # Python's CSV reader raises an error, which must be caught.
    row = {"shot": "1", "ball": "cue", "t": "0", "x": "0", "y": "0"} | {place: "9" * 2_000_000}
    with pytest.raises(TracksError) as refused:
        read(tmp_path, "shot,ball,t,x,y\n" + ",".join(row.values()) + "\n")
    said = str(refused.value)
    assert (
        "tracks.csv:2: expected fields of at most 131072 characters, found a line of 2000" in said
    )
    with pytest.raises(TracksError) as refused:
        read(tmp_path, "shot,ball,t,x,y\n1,cue,0,0," + "y" * 100_000)
    assert len(str(refused.value)) < 500


def test_a_byte_order_mark_is_no_part_of_the_header(tmp_path):
    # Excel writes a byte order mark into CSV files in UTF-8.
    assert read(tmp_path, "\ufeff" + GOOD.partition("\n")[2]).keys() == {"1", "2"}


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(TracksError, match=r"none.csv: can't read a CSV file of tracks"):
        read_tracks(tmp_path / "none.csv", SURFACE)
