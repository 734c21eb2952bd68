"""The physics of a scene: presets, and fields that would have no effect."""

from __future__ import annotations

import math
from typing import get_args

import pytest
from refusals import loading

from ghostball.model import Physics, SceneError
from ghostball.model.impact_laws import CUSHION_LAW_NAMES, CUSHION_LAWS

FLIES = {"motion": "sliding", "airborne": True}

CUSHION_FIELDS = sorted(
    {field for law in CUSHION_LAWS for field in law.uses} - {"sliding_friction"}
)
UNUSED = [
    (law.name, field) for law in CUSHION_LAWS for field in CUSHION_FIELDS if field not in law.uses
]


def test_the_paper_preset_is_the_paper():
    physics = Physics(preset="paper")
    assert physics == Physics()
    assert (physics.motion, physics.rolling_friction) == ("rolling", 0.02)
    assert (physics.ball_restitution, physics.cushion) == (1.0, "mirror")


def test_a_field_overrides_its_preset():
    physics = Physics(preset="pool", rolling_friction=0.005)
    assert physics.rolling_friction == 0.005
    assert physics.ball_restitution == 0.95


@pytest.mark.parametrize("value", ["sometimes", -0.1, math.nan])
def test_ball_friction_is_a_number_or_a_law(value):
    with pytest.raises(SceneError, match=r"`ball_friction` must be .*, or must be 'alciatore'"):
        Physics(ball_friction=value)


def test_a_restitution_of_the_table_needs_balls_that_land():
    with pytest.raises(SceneError, match=r"`table_restitution` = .* has no effect with `airborne`"):
        Physics(table_restitution=0.3)
    assert Physics(table_restitution=0.3, motion="sliding", airborne=True).table_restitution == 0.3
    assert Physics(table_restitution=0.5).airborne is False  # the default value is allowed


@pytest.mark.parametrize(
    ("physics", "message"),
    [
        ({"airborne": True}, '`motion` must be "sliding" if `airborne` = true, got "rolling"'),
        ({"preset": "paper", "airborne": True}, '`motion` must be "sliding" if `airborne`'),
        (FLIES | {"ball_impact": "mathavan2014"}, '`ball_impact` must be "frictional" if'),
        (FLIES | {"cushion": "mathavan2010"}, '`cushion` must be "mirror", "restitution"'),
    ],
)
def test_physics_that_cannot_fly(physics, message):
    with pytest.raises(SceneError) as refused:
        Physics(**physics)
    assert message in str(refused.value)


class TestFieldsWithoutEffect:
    """A field that the chosen law ignores is refused, because setting it is a mistake."""

    @pytest.mark.parametrize("preset", sorted(Physics.PRESETS))
    @pytest.mark.parametrize(("law", "field"), UNUSED)
    def test_a_field_that_the_cushion_law_ignores(self, law, field, preset):
        value = 1.5 if field == "cushion_frequency_ratio" else 0.03
        with pytest.raises(SceneError) as caught:
            Physics(preset=preset, cushion=law, **{field: value})
        message = str(caught.value)
        assert f'`{field}` = {value} has no effect with `cushion` = "{law}"' in message
        assert "or remove the field" in message
        for other in CUSHION_LAWS:
            assert (f'"{other.name}"' in message.split("Set ")[1]) == (field in other.uses)

    @pytest.mark.parametrize("law", CUSHION_LAW_NAMES)
    @pytest.mark.parametrize("preset", sorted(Physics.PRESETS))
    def test_what_preset_or_default_give_is_allowed_also_when_spelled_out(self, preset, law):
        # So the law of a preset can be replaced without other changes.
        given = Physics(preset=preset)
        fields = {field for other in CUSHION_LAWS for field in other.uses}
        for source in (given, Physics()):
            spelled_out = {field: getattr(source, field) for field in fields}
            assert Physics(preset=preset, cushion=law, **spelled_out).cushion == law

    @pytest.mark.parametrize("field", ["rolling_friction_quadratic", "cushion_restitution_loss"])
    def test_a_zero_that_a_preset_has_otherwise_is_kept(self, field):
        given = Physics(preset="carom", **{field: 0.0})
        assert Physics.model_validate_json(given.model_dump_json()) == given

    def test_the_presets_that_a_scene_may_name_are_all_there(self):
        assert get_args(Physics.model_fields["preset"].annotation) == tuple(Physics.PRESETS)

    @pytest.mark.parametrize("field", ["rolling_friction_quadratic", "cushion_restitution_loss"])
    def test_a_zero_of_a_field_that_came_later_is_left_out(self, field):
        # So scenes that were stored before this field existed stay equal.
        assert field not in Physics(preset="pool").model_dump()

    def test_in_a_file_the_line_is_the_field_s(self):
        text = 'schema = 1\nname = "a"\n[physics]\npreset = "paper"\ncushion_friction = 0.5\n'
        text += '[[balls]]\nid = "a"\nposition = [0, 0]\n'
        assert loading(text) == (
            'shot.toml:5: `cushion_friction` = 0.5 has no effect with `cushion` = "mirror". Set '
            '`cushion` = "frictional", "han2005", "mathavan2010" or "stronge2000", or remove the '
            "field."
        )
