"""What can be fitted, and of which engine."""

import pytest

from ghostball.model import Physics
from ghostball.reference_adapters import make_engine
from ghostball.validation.measured.fit.fields import FIELDS, cushion_laws, lacking, own_fields


def test_fields_are_those_of_physics():
    assert set(FIELDS) <= set(Physics.model_fields)


def test_an_engine_that_has_all_of_a_preset_lacks_nothing():
    assert lacking(make_engine("ghostball"), "pool") == {}


def test_what_an_engine_lacks_is_held_where_it_has_it():
    engine = make_engine("pybullet")
    held = lacking(engine, "pool")
    assert held["rolling_friction_quadratic"] == held["cushion_restitution_loss"] == 0.0
    assert held["cushion"] in [law.name for law in cushion_laws(engine)]


@pytest.mark.parametrize(
    ("law", "names"),
    [
        ("restitution", {"cushion_restitution", "cushion_restitution_loss"}),
        (
            "han2005",
            {
                "cushion_restitution",
                "cushion_restitution_loss",
                "cushion_friction",
                "cushion_height",
            },
        ),
    ],
)
def test_a_law_has_the_fields_that_it_uses_and_contacts_alone_tell(law, names):
    (entry,) = (one for one in cushion_laws(make_engine("ghostball")) if one.name == law)
    assert {one.name for one in own_fields(entry, list(FIELDS.values()))} == names
