"""Settings of time-stepping engines."""

import math

import pytest
from pydantic import ValidationError

from ghostball.reference_adapters.pybullet.engine import PybulletSettings
from ghostball.reference_adapters.pymunk.engine import PymunkSettings


@pytest.mark.parametrize(
    "settings",
    [
        {"dt": 0.0},
        {"dt": -1e-3},
        {"dt": math.nan},
        {"dt": math.inf},
        {"iterations": 0},
        {"max_time": 0.0},
        {"max_steps": 0},
        {"contact_steps": "continuous"},
        {"config": "best"},
        {"time_step": 1e-3},
    ],
)
def test_bad_settings_are_refused(settings):
    with pytest.raises(ValidationError):
        PymunkSettings(**settings)


@pytest.mark.parametrize("settings", [{"contact_steps": "exact"}, {"config": "naive"}])
def test_an_own_cloth_needs_fixed_steps_and_the_tuned_configuration(settings):
    with pytest.raises(ValidationError, match="`cloth` = own needs `contact_steps` = fixed"):
        PymunkSettings(cloth="own", **settings)


def test_steps_to_contacts_need_the_tuned_configuration():
    with pytest.raises(ValidationError, match="`contact_steps` = exact needs `config` = tuned"):
        PybulletSettings(contact_steps="exact", config="naive")
