"""The rules between a scene's laws of impacts and its balls and table."""

from __future__ import annotations

import math

import pytest
from refusals import loading, refusal
from shots import POOL_TABLE, R, ball, scene_of

from ghostball.model import SceneError, Table
from ghostball.model.impact_laws import BALL_LAWS

SPIN_LAWS = ("frictional", "han2005", "mathavan2010")
HEIGHT_LAWS = ("han2005", "mathavan2010")
FLIES = {"motion": "sliding", "airborne": True}


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

    def test_where_balls_may_fly_it_is_below_their_tops_whatever_the_law(self):
        message = refusal(ball((1, 0.5)), table=POOL_TABLE, cushion_height=0.08, **FLIES)
        assert "`cushion_height` must be less than the height of every ball where" in message
        assert message.endswith("or `airborne` = false.")


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
