"""What a stored field may hold: floats read back to the bit, and what is damaged is refused."""

from dataclasses import dataclass

import numpy as np
import pytest
from pydantic import ConfigDict, TypeAdapter, ValidationError
from stored_cases import SCENE

from ghostball.validation.results.fields import (
    Definition,
    EnvironmentValues,
    StoredArray,
    check_shape,
)


@dataclass
class Held:
    places: StoredArray
    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)


HELD = TypeAdapter(Held)


def test_an_array_reads_back_to_the_bit_and_null_is_not_finite():
    places = np.array([[0.1 + 0.2, -0.0], [5e-324, np.inf]])
    found = HELD.validate_json(HELD.dump_json(Held(places))).places
    assert np.isnan(found[1, 1])
    found[1, 1] = np.inf
    assert found.tobytes() == places.tobytes()


@pytest.mark.parametrize("damaged", ["[[1, 2], [3]]", '["x"]', "{}"])
def test_what_is_no_array_is_refused(damaged):
    with pytest.raises(ValidationError, match="must be numbers in rows of one length"):
        HELD.validate_json(f'{{"places": {damaged}}}')


def test_another_shape_is_refused_by_name():
    check_shape("rests", None, (2, 3))
    with pytest.raises(ValueError, match=r"`rests` must have the shape \(2, 3\), got \(3, 2\)"):
        check_shape("rests", np.zeros((3, 2)), (2, 3))


def test_a_definition_must_be_a_scene():
    plain = SCENE.model_dump(mode="json", by_alias=True)
    assert TypeAdapter(Definition).validate_python(plain) == plain
    with pytest.raises(ValidationError, match=r"must be a scene: .*`t_max`"):
        TypeAdapter(Definition).validate_python(plain | {"t_max": -1.0})


def test_an_environment_may_say_more_but_nothing_else():
    adapter = TypeAdapter(EnvironmentValues)
    assert adapter.validate_python({"cpu": "any", "more": 1}) == {"cpu": "any", "more": 1}
    with pytest.raises(ValidationError, match=r"git\.revision"):
        adapter.validate_python({"git": {"dirty": False}})
