"""The pictures of the README, made by `python -m benchmarks gallery`."""

import pytest

from benchmarks.pictures import gallery
from benchmarks.pictures.gallery import write_gallery
from ghostball.model import GhostballError
from ghostball.reports import style


def test_the_gallery_is_complete(results_folder, tmp_path, monkeypatch):
    # How a figure is written is tested with figures; drawing all of these takes seconds.
    monkeypatch.setattr(style, "lay_out", lambda _: None)
    monkeypatch.setattr(style, "save_one", lambda figure, path, _: path.write_text(str(figure)))
    # These results have no chaotic scene.
    figures = {name: draw for name, draw in gallery.GALLERY.items() if name != "chaos"}
    monkeypatch.setattr(gallery, "GALLERY", figures)
    folder = tmp_path / "new" / "gallery"
    written = write_gallery(results_folder, folder)
    assert sorted(written) == sorted(folder.iterdir())
    names = {path.stem for path in written}
    assert {path.suffix for path in written} == {".png"}
    assert all(path.read_text().startswith("Figure(") for path in written)
    assert {"hero", "paper-figure-2"} <= names
    assert {"physics-deflection", "physics-throw", "precision", "racks", "board"} <= names


def test_a_gallery_without_its_scenes_is_an_error(small_folder, tmp_path):
    with pytest.raises(GhostballError, match='scene "pocket-break-9"'):
        write_gallery(small_folder, tmp_path / "gallery")
    assert not (tmp_path / "gallery").exists()
