"""Fails where a version is lost, invented, taken from another file or put in another order."""

import shutil

import pytest
from measured_history import Repository, targets

from ghostball.validation.bench import BenchError, measurements
from ghostball.validation.bench._observed import KINDS, observed_in
from ghostball.validation.bench.history import read_history
from ghostball.validation.bench.measurements import STORE
from ghostball.validation.results.git import GitError


@pytest.fixture
def repository(tmp_path, monkeypatch):
    """A checkout without measurements, which the history is read from."""
    made = Repository(tmp_path / "checkout")
    (made.path / "README").touch()
    made.commit()
    monkeypatch.setattr(measurements, "CHECKOUT", made.path)
    return made


@pytest.fixture
def measured(repository):
    """Three versions of one machine, the file renamed between them; one of another machine."""
    repository.put("old-name/targets.json", targets("a" * 40, 1, 40e-6))
    repository.commit()
    (repository.path / "benchmarks/results/old-name").rename(
        repository.path / "benchmarks/results/box"
    )
    repository.put("box/targets.json", targets("b" * 40, 3, 20e-6, dirty=True))
    repository.commit()
    repository.put("other/targets.json", targets("b" * 40, 2, 60e-6))
    repository.put("box/targets.json", targets("c" * 40, 4, 10e-6))
    repository.commit()
    return repository


def test_each_version_is_read_in_order_of_time_through_a_renaming(measured):
    history = read_history()
    assert [(one.machine, one.revision[0], one.date[:10]) for one in history.versions] == [
        ("box", "a", "2026-01-01"),
        ("other", "b", "2026-01-02"),
        ("box", "b", "2026-01-03"),
        ("box", "c", "2026-01-04"),
    ]
    kernels = [one.values["break/kernel"] for one in history.of("box")]
    assert [one.value for one in kernels] == [40e-6, 20e-6, 10e-6]
    assert (kernels[0].low, kernels[0].high) == (0.9 * 40e-6, 1.5 * 40e-6)
    assert (kernels[0].target, kernels[0].target_kind) == (3e-5, "at_most")
    assert [one.dirty for one in history.of("box")] == [False, True, False]
    assert history.machines == ("box", "other")
    assert not history.cut
    assert history.unread == ()


def test_the_commit_is_that_which_stored_it(measured):
    *_, last = read_history().versions
    assert last.commit == measured.git("rev-parse", "HEAD").strip()


def test_a_pattern_chooses_quantities(measured):
    history = read_history(pattern="*/bytes*")
    assert history.quantities == ("break/bytes_per_ball",)
    with pytest.raises(BenchError, match=r"`--quantity` must match .* 'nosuch'.* break/kernel"):
        read_history(pattern="nosuch")


def test_versions_that_cannot_be_read_are_named_and_left_out(measured):
    measured.put("box/targets.json", {**targets("d" * 40, 5, 1e-6), "schema": 2})
    other_schema = measured.commit()
    measured.put("box/targets.json", "{")
    cut_short = measured.commit()
    measured.put("box/targets.json", targets("e" * 40, 7, 5e-6))
    measured.commit()
    history = read_history()
    assert [one.revision[0] for one in history.of("box")] == ["a", "b", "c", "e"]
    whys = {one.commit: one.why for one in history.unread}
    assert set(whys) == {other_schema, cut_short}
    assert "`schema`" in whys[other_schema]
    assert "JSON" in whys[cut_short]


def test_a_deleted_file_that_comes_back_has_all_its_versions(measured):
    path = measured.path / "benchmarks/results/box/targets.json"
    text = path.read_text()
    path.unlink()
    measured.commit()
    measured.put("box/targets.json", text.replace("c" * 40, "f" * 40).replace("-04T", "-08T"))
    measured.commit()
    assert [one.revision[0] for one in read_history().of("box")][-2:] == ["c", "f"]


def test_a_new_machine_has_no_history_of_another(measured):
    """Breaks with `git log --follow`, which takes a new file for a copy of one that is like it."""
    measured.put("new/targets.json", targets("c" * 40, 5, 10e-6))
    measured.commit()
    assert [one.date[:10] for one in read_history().of("new")] == ["2026-01-05"]


def test_a_shallow_clone_is_cut_and_says_so(measured, tmp_path, monkeypatch):
    clone = tmp_path / "clone"
    measured.git("clone", "--quiet", "--depth=1", f"file://{measured.path}", str(clone))
    monkeypatch.setattr(measurements, "CHECKOUT", clone)
    history = read_history()
    assert history.cut
    assert [one.revision[0] for one in history.of("box")] == ["c"]


def test_what_was_never_measured_is_an_error_that_names_what_was(measured):
    with pytest.raises(
        BenchError, match=r"no measurement of `stress`.* There are: targets\. `ghost"
    ):
        read_history("stress")


def test_a_checkout_without_measurements_is_an_error(repository):
    with pytest.raises(BenchError, match="There is none at all"):
        read_history()


def test_nothing_that_can_be_read_is_an_error(repository):
    repository.put("box/targets.json", "[]")
    repository.commit()
    with pytest.raises(BenchError, match=r"box/targets\.json at .*: must be"):
        read_history()


def test_an_unknown_kind_is_refused(repository):
    with pytest.raises(BenchError, match=r"kind must be one of targets, scaling, .*'target'"):
        read_history("target")


def test_what_is_no_checkout_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(measurements, "CHECKOUT", tmp_path)
    with pytest.raises(BenchError, match="is no checkout"):
        read_history()


def test_git_that_is_not_there_is_said(measured, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda _: None)
    with pytest.raises(BenchError, match="isn't installed"):
        read_history()


def test_a_repository_that_git_refuses_is_an_error_with_its_reason(measured):
    (measured.path / ".git" / "HEAD").write_text("nonsense")
    with pytest.raises(GitError, match=r"`git ls-files .*` failed: fatal"):
        read_history()


@pytest.mark.parametrize("path", sorted(STORE.glob("*/*.json")), ids=lambda path: path.stem)
def test_every_committed_measurement_has_numbers(path):
    assert path.stem in KINDS
    values = observed_in(path.stem, path.read_text()).values
    assert values
    assert all(isinstance(one.value, int | float) for one in values.values())
    if path.stem in ("accuracy", "skips", "stress"):
        assert all(one.low is None and one.high is None for one in values.values())


def test_within_a_hook_of_another_repository_it_reads_its_own(measured, tmp_path, monkeypatch):
    Repository(tmp_path / "other").commit()
    monkeypatch.setenv("GIT_DIR", str(tmp_path / "other" / ".git"))
    monkeypatch.setenv("GIT_INDEX_FILE", str(tmp_path / "other" / ".git" / "index"))
    assert len(read_history().of("box")) == 3
