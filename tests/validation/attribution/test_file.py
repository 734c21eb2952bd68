"""Attributions in a results folder: written, read back, kept, refused."""

from dataclasses import replace

import pytest

from reference_adapters import make_engine
from validation import ResultsError, ResultsFolder, find_scene, run_suite
from validation.attribution import (
    ATTRIBUTIONS_FILE,
    attribute_many,
    attribute_results,
    attributions_of,
    read_attributions,
    write_attributions,
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("attributed")
    run_suite([find_scene("stop")], ["ghostball", "paper-discrete", "pymunk:mode=landed"], path)
    return path


def test_every_foreign_case_is_attributed_and_reads_back(folder):
    results, seen = ResultsFolder.load(folder), []
    found = attribute_results(results, progress=lambda *what: seen.append(what))
    assert [one.label for one in found] == ["paper-discrete", "pymunk:mode=landed"]
    assert read_attributions(folder) == found
    assert attributions_of(results) == found
    assert seen[-1] == (2, 2, "stop on pymunk:mode=landed")
    assert not list(folder.glob("*.part"))


def test_what_is_there_is_not_computed_again(folder, monkeypatch):
    results = ResultsFolder.load(folder)
    found = attribute_results(results)
    monkeypatch.setattr("validation.attribution._many.attribute", None)
    assert attribute_results(results) == found


def test_another_code_or_scene_makes_it_no_attribution_of_the_case(folder):
    results = ResultsFolder.load(folder)
    found = attribute_results(results)
    for change in ({"code_hash": "x"}, {"definition_hash": "x"}):
        write_attributions(folder, [replace(found[0], **change), found[1]])
        assert attributions_of(results) == found[1:]
    write_attributions(folder, found)


def test_without_a_file_there_are_none(tmp_path):
    assert read_attributions(tmp_path) == []


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ('{"schema": 99}', "`schema` must be 1, got 99"),
        ("{", "not valid JSON"),
        ("[]", "a JSON object was expected"),
        ('{"schema": 1, "scene": "stop"}', "`label`"),
    ],
)
def test_damage_is_refused_with_its_place(tmp_path, line, said):
    path = tmp_path / ATTRIBUTIONS_FILE
    path.write_text(line + "\n")
    with pytest.raises(ResultsError) as error:
        read_attributions(tmp_path)
    assert f"{path}:1" in str(error.value)
    assert said in str(error.value)


def test_a_folder_that_cannot_be_written_is_refused(tmp_path):
    with pytest.raises(ResultsError, match="can't write"):
        write_attributions(tmp_path / "nowhere", [])


def test_pairs_that_an_engine_lacks_are_left_out():
    assert attribute_many([(find_scene("sliding-stun"), "paper-discrete")]) == []


@pytest.mark.slow
def test_processes_find_the_same():
    pairs = [(find_scene(name), "paper-continuous") for name in ("stop", "head-on")]
    assert attribute_many(pairs, jobs=2) == attribute_many(pairs)
    assert make_engine("paper-continuous").settings.frame == 0.02
