"""What the engine says is the same, as checks that any scene can be put to.

>>> differences(random_scene(17))
{}

A check is a function of a scene that returns a sentence where two that must be the same differ, and
None where they don't, or where the scene has nothing to compare. `CHECKS` has them all by name.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Final

from ghostball.model import Scene
from same import images, motion, plays, stored

Check = Callable[[Scene], str | None]

CHECKS: Final[Mapping[str, Check]] = {
    "ends": motion.ends,
    "sampled": motion.sampled,
    "invariants": motion.invariants,
    "records": plays.records,
    "many": plays.many,
    "sweep": plays.sweep,
    "starts": plays.starts,
    "cells": plays.cells,
    "skips": plays.skipped,
    "renumbered": images.renumbered,
    "mirrored": images.mirrored,
    "scene-file": stored.scene_file,
    "results": stored.results,
    "proof": stored.proof,
}

SELDOM: Final = ("results", "proof")
"""Checks that take a hundred times what others do."""

OFTEN: Final = tuple(name for name in CHECKS if name not in SELDOM)


def differences(scene: Scene, only: Collection[str] = CHECKS) -> dict[str, str]:
    """Return what differs in a scene that must be the same: a sentence by the name of its check.

    A run that doesn't end is compared no further.
    """
    found: dict[str, str] = {}
    for name, check in CHECKS.items():
        if name in only or name == "ends":
            sentence = check(scene)
            if sentence is not None:
                found[name] = sentence
                if name == "ends":
                    break
    return found
