"""The rules between a scene's impact laws and its other fields."""

from __future__ import annotations

import math
import subprocess
import sys

import pytest
from refusals import loading, refusal
from shots import POOL_TABLE, R, ball, scene_of

from ghostball.model import Physics, SceneError, Table
from ghostball.model.impact_laws import BALL_LAWS, CUSHION_LAW_NAMES, CUSHION_LAWS

SPIN_LAWS = ("frictional", "han2005", "mathavan2010")
HEIGHT_LAWS = ("han2005", "mathavan2010")

CUSHION_FIELDS = sorted(
    {field for law in CUSHION_LAWS for field in law.uses} - {"sliding_friction"}
)
UNUSED = [
    (law.name, field) for law in CUSHION_LAWS for field in CUSHION_FIELDS if field not in law.uses
]


def test_a_restitution_of_the_table_needs_balls_that_land():
    with pytest.raises(SceneError, match=r"`table_restitution` = .* has no effect with `airborne`"):
        Physics(table_restitution=0.3)
    assert Physics(table_restitution=0.3, motion="sliding", airborne=True).table_restitution == 0.3
    assert Physics(table_restitution=0.5).airborne is False  # the default does no harm


class TestLawNames:
    def test_knowing_the_laws_needs_no_compiler(self):
        check = "import sys, ghostball.engine; assert 'numba' not in sys.modules"
        subprocess.run([sys.executable, "-c", check], check=True)


class TestFieldsWithoutEffect:
    """A field that the chosen law ignores in silence is a mistake of whoever set it."""

    @pytest.mark.parametrize("preset", ["paper", "pool", "pool-coulomb"])
    @pytest.mark.parametrize(("law", "field"), UNUSED)
    def test_a_field_that_the_cushion_law_ignores(self, law, field, preset):
        with pytest.raises(SceneError) as caught:
            Physics(preset=preset, cushion=law, **{field: 0.03})
        message = str(caught.value)
        assert f'`{field}` = 0.03 has no effect with `cushion` = "{law}"' in message
        assert "or leave the field out" in message
        for other in CUSHION_LAWS:
            assert (f'"{other.name}"' in message.split("Set ")[1]) == (field in other.uses)

    @pytest.mark.parametrize("law", CUSHION_LAW_NAMES)
    @pytest.mark.parametrize("preset", ["paper", "pool", "pool-coulomb"])
    def test_what_preset_or_default_give_is_allowed_also_when_spelled_out(self, preset, law):
        # So that a preset's law can be swapped for another with nothing else changed.
        given = Physics(preset=preset)
        fields = {field for other in CUSHION_LAWS for field in other.uses}
        for source in (given, Physics()):
            spelled_out = {field: getattr(source, field) for field in fields}
            assert Physics(preset=preset, cushion=law, **spelled_out).cushion == law

    def test_in_a_file_the_line_is_the_field_s(self):
        text = 'schema = 1\nname = "a"\n[physics]\npreset = "paper"\ncushion_friction = 0.5\n'
        text += '[[balls]]\nid = "a"\nposition = [0, 0]\n'
        assert loading(text) == (
            'shot.toml:5: `cushion_friction` = 0.5 has no effect with `cushion` = "mirror". Set '
            '`cushion` = "frictional", "han2005" or "mathavan2010", or leave the field out.'
        )


class TestLawsThatActThroughSpin:
    """Where motion is "rolling" a ball has the spin of its velocity: no impact may turn it."""

    @pytest.mark.parametrize("law", SPIN_LAWS)
    def test_cushion_laws_with_friction_need_sliding(self, law):
        message = refusal(ball((1, 1)), table=POOL_TABLE, cushion=law)
        assert f'`motion` must be "sliding" with `cushion` = "{law}":' in message
        assert 'Set `motion` = "sliding", or `cushion` = "mirror" or "restitution".' in message
        assert scene_of(ball((1, 1)), table=POOL_TABLE, cushion=law, motion="sliding")

    @pytest.mark.parametrize("law", SPIN_LAWS)
    @pytest.mark.parametrize("table", [None, Table(length=2, width=2, cushions=())])
    def test_a_cushion_law_without_a_cushion_does_no_harm(self, law, table):
        assert scene_of(ball((1, 1)), table=table, cushion=law).physics.cushion == law

    @pytest.mark.parametrize(
        ("fields", "found", "mended"),
        [
            ({"ball_friction": 0.05}, "`ball_friction` = 0.05:", "or `ball_friction` = 0."),
            (
                {"ball_friction": "alciatore"},
                '`ball_friction` = "alciatore":',
                "or `ball_friction` = 0.",
            ),
            (
                {"ball_impact": "mathavan2014"},
                '`ball_impact` = "mathavan2014":',
                'or `ball_impact` = "frictional".',
            ),
        ],
    )
    def test_friction_between_balls_needs_sliding_and_two_balls(self, fields, found, mended):
        message = refusal(ball((0, 0)), ball((1, 0)), **fields)
        assert f'`motion` must be "sliding" with {found}' in message
        assert message.endswith(mended)
        assert scene_of(ball((0, 0)), ball((1, 0)), motion="sliding", **fields)
        assert scene_of(ball((0, 0)), **fields)

    def test_a_preset_with_motion_overridden_tells_every_field_to_set(self):
        balls = (ball((1, 1)), ball((0.5, 0.5)))
        message = refusal(*balls, table=POOL_TABLE, preset="pool", motion="rolling")
        assert (
            '`cushion` = "han2005" (of preset "pool") and '
            '`ball_friction` = "alciatore" (of preset "pool")'
        ) in message
        assert 'or `cushion` = "mirror" or "restitution" and `ball_friction` = 0' in message
        mended = {"cushion": "restitution", "ball_friction": 0.0}
        scene_of(*balls, table=POOL_TABLE, preset="pool", motion="rolling", **mended)

    def test_in_a_file_the_line_is_that_of_the_law_or_else_of_the_physics(self):
        start = 'schema = 1\nname = "a"\n[physics]\nmotion = "rolling"\n'
        end = '[table]\nlength = 2\nwidth = 2\n[[balls]]\nid = "a"\nposition = [1, 1]\n'
        assert loading(start + 'cushion = "han2005"\n' + end).startswith("shot.toml:5: `motion`")
        assert loading(start + 'preset = "pool"\n' + end).startswith("shot.toml:3: `motion`")


class TestCushionHeight:
    def shot(self, law, height, *radii, table=POOL_TABLE):
        balls = [ball((0.3 + 0.4 * i, 0.6), radius=radius) for i, radius in enumerate(radii)]
        return scene_of(*balls, table=table, motion="sliding", cushion=law, cushion_height=height)

    @pytest.mark.parametrize("law", HEIGHT_LAWS)
    def test_the_nose_is_below_the_top_of_every_ball(self, law):
        with pytest.raises(SceneError) as caught:
            self.shot(law, 0.05, R, 0.02, 0.03)
        message = str(caught.value)
        assert f'must be less than the height of every ball where `cushion` = "{law}"' in message
        assert "got 0.05 m, but `balls[1]` is 0.04 m high" in message
        assert '`cushion` = "mirror", "restitution" or "frictional"' in message

    @pytest.mark.parametrize("law", HEIGHT_LAWS)
    def test_the_top_itself_is_too_high_and_a_rounding_below_it_is_not(self, law):
        # At the top the contact's normal is vertical: no cushion would turn the ball back.
        with pytest.raises(SceneError, match="less than the height"):
            self.shot(law, 2 * R, R)
        self.shot(law, math.nextafter(2.0, 0.0) * R, R)

    @pytest.mark.parametrize("law", HEIGHT_LAWS)
    def test_a_nose_lost_in_the_rounding_of_a_ball(self, law):
        with pytest.raises(SceneError, match="`cushion_height` must be distinct from the cloth's"):
            self.shot(law, 1e-20, R)
        self.shot(law, 1e-3, R)

    @pytest.mark.parametrize("table", [None, Table(length=2, width=2, cushions=())])
    def test_a_table_without_cushions_takes_any_ball(self, table):
        assert self.shot("han2005", 0.05, 0.01, table=table)


class TestLimits:
    def shot(self, *friction, **fields):
        balls = [
            ball((0.4 * i, 0), id=f"b{i}", sliding_friction=value)
            for i, value in enumerate(friction)
        ]
        return scene_of(*balls, motion="sliding", ball_impact="mathavan2014", **fields)

    @pytest.mark.parametrize(("field", "most"), BALL_LAWS[1].limits)
    def test_a_law_takes_coefficients_up_to_its_limit(self, field, most):
        self.shot(None, None, **{field: most})
        beyond = math.nextafter(most, 2.0)
        with pytest.raises(SceneError, match=f"`{field}` must be at most {most} where") as caught:
            self.shot(None, None, **{field: beyond})
        assert f'"mathavan2014", got {beyond}' in str(caught.value)
        assert '`ball_impact` = "frictional"' in str(caught.value)

    def test_a_ball_s_own_cloth_counts(self):
        self.shot(0.7, 0.2)
        with pytest.raises(SceneError, match=r"`balls\[1\].sliding_friction` must be at most 0.7"):
            self.shot(0.2, 0.8)
