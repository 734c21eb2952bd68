"""Checks of equalities that the engine promises, for any scene.

>>> differences(random_scene(17))
{}

A check is a function of a scene. It returns a sentence if two results that must be equal differ,
and None if they are equal or if the scene has nothing to compare. `CHECKS` contains all checks by
name.
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
"""Checks that take a hundred times as long as the other checks."""

OFTEN: Final = tuple(name for name in CHECKS if name not in SELDOM)


def differences(scene: Scene, only: Collection[str] = CHECKS) -> dict[str, str]:
    """Return a sentence for each failed check of a scene, by the name of the check.

    If a run doesn't finish, the remaining checks are skipped.
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
