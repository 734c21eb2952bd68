"""What an engine is asked: settings that it has, and scenes as it can play them."""

from __future__ import annotations

from typing import ClassVar

import pytest
from engine_facts import needs

from ghostball.model.features import EXACT, Feature
from ghostball.reference_adapters import EngineBase, EngineSettings, make_engine
from ghostball.validation.board.asking import asked, board_scene, playable, with_settings
from ghostball.validation.board.column import COLUMNS, Settings

TO_CONTACTS, STEPPED = Settings(contact_steps="exact"), Settings(step=1e-3, contact_steps="fixed")


def test_settings_are_added_where_an_engine_has_them():
    assert with_settings("pymunk", TO_CONTACTS) == "pymunk:contact_steps=exact"
    stepped = with_settings("pymunk", STEPPED)
    assert stepped == "pymunk:dt=0.001,max_steps=1000000,contact_steps=fixed"
    assert with_settings("pymunk:dt=0.01", STEPPED).startswith("pymunk:dt=0.01,")
    assert with_settings("pymunk:contact_steps=fixed", TO_CONTACTS) is None
    framed = with_settings("paper-continuous", STEPPED)
    assert framed == "paper-continuous:frame=0.001,max_events=1000000"
    assert with_settings("paper-continuous", TO_CONTACTS) is None
    assert with_settings("ghostball", STEPPED) is None
    assert with_settings("board_engines:Slowing", STEPPED) is None


@needs("pybullet")
def test_settings_that_exclude_each_other_are_not_added():
    assert with_settings("pybullet:config=naive", TO_CONTACTS) is None


def test_a_column_asks_each_of_its_settings_of_each_of_its_scenes():
    assert [label for _, _, label in asked(COLUMNS["um"], "pymunk")] == [
        "pymunk:contact_steps=exact",
        *(
            f"pymunk:dt={dt},max_steps=1000000,contact_steps=fixed"
            for dt in ("0.01", "0.003", "0.001", "0.0003", "0.0001")
        ),
    ]
    assert [name for name, _, _ in asked(COLUMNS["break"], "pymunk")] == [
        "open-rack-1",
        "open-rack-2",
        "open-rack-3",
    ]
    # What lacks the settings is asked as it is, but where they are the question.
    assert [label for _, _, label in asked(COLUMNS["um"], "ghostball")] == ["ghostball"]
    assert asked(COLUMNS["exact-steps"], "ghostball") == []


class Lacking(EngineBase):
    """An engine that lacks what its subclass says."""

    name: ClassVar[str] = "lacking"
    Settings: ClassVar[type[EngineSettings]] = EngineSettings
    missing: ClassVar[frozenset[Feature]] = frozenset({Feature.ROLLING})

    @property
    def capabilities(self):
        return {one: EXACT for one in Feature if one not in self.missing}

    def lacks(self, scene):
        return ("two at once",) if scene.physics.impacts == "simultaneous" else ()

    def simulate(self, scene, *, record="rest"):
        raise NotImplementedError


@pytest.mark.parametrize(("name", "friction"), [("open-rack-1", 0.0), ("cut-to-rest", 0.2)])
def test_an_engine_that_only_slides_plays_a_scene_in_which_that_is_the_same(name, friction):
    scene = board_scene(name)
    assert playable(scene, make_engine("ghostball")) == scene
    played = playable(scene, Lacking())
    assert played.name == f"{name}-sliding-sequential"
    assert (played.physics.motion, played.physics.impacts) == ("sliding", "sequential")
    assert played.physics.sliding_friction == friction


def test_a_scene_that_an_engine_lacks_something_for_is_asked_as_it_is():
    class Nothing(Lacking):
        missing: ClassVar[frozenset[Feature]] = frozenset(Feature)

    assert playable(board_scene("throw"), Nothing()) == board_scene("throw")
