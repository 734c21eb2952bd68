"""Each cache has a folder of its own, in the one that the user chose."""

from pathlib import Path

from ghostball.model.cache_folder import CHOSEN, cache_folder


def test_all_caches_are_in_the_chosen_folder(monkeypatch, tmp_path):
    monkeypatch.setenv(CHOSEN, str(tmp_path))
    assert cache_folder("proofs") == tmp_path / "proofs"
    assert not list(tmp_path.iterdir())  # whoever keeps something makes it


def test_without_a_choice_they_are_in_the_systems_folder_for_us(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("HOME", str(tmp_path))
    for chosen in (None, ""):
        monkeypatch.delenv(CHOSEN, raising=False)
        if chosen is not None:
            monkeypatch.setenv(CHOSEN, chosen)
        folder = cache_folder("libraries")
        assert folder.name == "libraries"
        assert "ghostball" in folder.parent.parts[-1].lower()
        assert folder.is_relative_to(Path(tmp_path))
