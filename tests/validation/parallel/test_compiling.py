"""Missing kernels are compiled in parallel, once each."""

import pickle

import pytest

from ghostball.validation.parallel import compiling
from ghostball.validation.scenes.library import find_scene

SCENES = [find_scene(name) for name in ("stop", "half-ball-cut", "mathavan-cut")]


class Part:
    """A substitute for a kernel."""

    def __init__(self, name, *, made=False):
        self.name, self.is_made = name, made

    def load(self):
        assert self.is_made


@pytest.fixture
def parts(monkeypatch):
    """Return a function that sets the needed kernels and returns the list of compiled ones."""

    def asked(*given):
        asked_for = [Part(name, **options) for name, options in given]
        monkeypatch.setattr(compiling, "kernels_of", lambda *_, **__: asked_for)
        made = []

        def make_all(missing, jobs, finished):
            for one in missing:
                one.is_made = True
                made.append((one.name, jobs))
                finished(one.name)

        monkeypatch.setattr(compiling, "make_all", make_all)
        return made

    return asked


def test_what_is_missing_is_made_side_by_side_and_can_be_loaded_then(parts, caplog):
    made = parts(("a", {}), ("b", {}), ("c", {"made": True}))
    load_all = compiling.compile_kernels(SCENES, 2)
    assert made == [("a", 2), ("b", 2)]
    assert "compiling: 0 of 2 are done of the engine's kernels" in caplog.text
    assert "compiling: 2 of 2 are done" in caplog.text
    load_all()


def test_what_is_compiled_is_counted_from_the_start(parts, caplog):
    parts(("a", {}), ("b", {"made": True}), ("c", {}))
    said = []
    compiling.compile_kernels(SCENES, 1, compiling=lambda *one: said.append(one))
    assert said == [(0, 2, ""), (1, 2, "a"), (2, 2, "c")]
    assert caplog.text == ""  # a caller that counts also reports the progress


def test_what_is_made_is_not_counted_again(parts):
    parts(("a", {"made": True}))
    compiling.compile_kernels(SCENES, 2, compiling=lambda *_: pytest.fail("nothing was missing"))


def test_what_scenes_need_is_ready_afterwards_and_can_be_loaded_elsewhere():
    load_all = compiling.compile_kernels(SCENES, 1)
    needed = compiling.kernels_of(SCENES)
    assert [one.name for one in needed] == ["shots"]
    assert all(one.is_made for one in needed)
    pickle.loads(pickle.dumps(load_all))()
