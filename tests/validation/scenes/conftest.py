"""Random scenes with few balls, created once."""

import pytest
from random_layouts import FEW

from ghostball.validation.scenes.random_scenes import random_scene


@pytest.fixture(scope="session")
def few():
    return [random_scene(number, count="few") for number in FEW]
