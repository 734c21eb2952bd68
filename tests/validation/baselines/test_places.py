"""Each engine has a folder of its own, whatever it is called, and each scene a file."""

import pytest

from ghostball.validation.baselines.places import (
    BaselineError,
    baseline_names,
    baseline_path,
    engine_folder,
    engine_key,
)


def test_an_engine_is_called_by_its_own_name_and_the_settings_that_it_was_given():
    where = "ghostball.validation.examples.stepper:Stepper:dt=1e-3"
    assert engine_key(where) == "stepper:dt=1e-3"
    assert engine_key("pymunk") == "pymunk"


def test_folders_of_engines_differ_and_stay_within(tmp_path):
    names = ("pymunk", "pymunk:dt=1e-3", "pymunk:dt=1e-4", "../else")
    folders = [engine_folder(tmp_path, name) for name in names]
    assert len({*folders}) == len(names)
    assert all(one.resolve().parent == tmp_path for one in folders)
    folders[0].touch()
    with pytest.raises(BaselineError, match=r"not a folder\. Choose another `--baselines`"):
        engine_folder(tmp_path, "pymunk")


def test_scenes_are_found_by_their_files(tmp_path):
    assert baseline_names(tmp_path / "none") == ()
    for name in ("b", "a"):
        baseline_path(tmp_path, name).touch()
    (tmp_path / "CHANGES.md").touch()
    assert baseline_names(tmp_path) == ("a", "b")
