"""Engines that a board must tell from right ones, and survive."""

import os
from typing import ClassVar

from planted_engines import OtherPhysicsEngine


class Slowing(OtherPhysicsEngine):
    """Our engine, but that balls bounce off each other with a restitution of 0.8."""

    name: ClassVar[str] = "slowing"
    physics: ClassVar[dict[str, object]] = {"ball_restitution": 0.8}


class Dying(Slowing):
    """An engine that takes its process with it."""

    name: ClassVar[str] = "dying"

    def simulate(self, scene, *, record="rest"):
        os._exit(3)
