"""The settings with which an engine reproduces measurements best."""

from __future__ import annotations

import tomllib
from importlib.resources import files
from typing import Any

import numpy as np

from ghostball.model import Physics
from ghostball.model.features import Capabilities, Feature, has_feature
from ghostball.model.impact_laws import CUSHION_LAWS
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.measured.facts import facts_of


def best_cushion(facts: str, engine: str, capabilities: Capabilities) -> dict[str, Any] | None:
    """Return the best cushion law and its coefficients for some facts; None: the engine has no law.

    The restitution decreases with speed if the engine supports this.
    """
    text = (files("ghostball.validation.measured") / "best.toml").read_text(encoding="utf-8")
    known = [one for one in tomllib.loads(text)["best"] if one["facts"] == facts]
    mine = [one for one in known if one["engine"] == engine]
    for one in mine or [one for one in known if one["engine"] == OURS]:
        law = next(law for law in CUSHION_LAWS if law.name == one["cushion"])
        falls = one["cushion_restitution_loss"] > 0.0
        needed = [Feature[law.feature or ""]] + [Feature.FALLING_RESTITUTION] * falls
        if all(has_feature(capabilities, feature) for feature in needed):
            return {name: value for name, value in one.items() if name not in ("facts", "engine")}
    return None


def best_cloth(facts: str, capabilities: Capabilities) -> dict[str, float]:
    """Return the rolling friction that fits measured decelerations best, and its speed dependence.

    If the engine's rolling friction can't depend on speed, only a constant is fitted.
    """
    rows = facts_of(facts).rows
    # equal weights without errors
    weights = np.array([1.0 / (row.error or 1.0) for row in rows])
    grows = has_feature(capabilities, Feature.QUADRATIC_ROLLING)
    columns = [np.ones(len(rows))] + [np.array([row.place**2 for row in rows])] * grows
    scaled = np.column_stack(columns) * weights[:, None]
    best = np.linalg.lstsq(scaled, np.array([row.value for row in rows]) * weights, rcond=None)[0]
    gravity = Physics().gravity
    return {
        "rolling_friction": float(best[0]) / gravity,
        "rolling_friction_quadratic": float(best[1]) if grows else 0.0,
    }


def carom_cloth(capabilities: Capabilities) -> dict[str, float]:
    """Return the rolling friction with which "cushion-carom" is fitted, as fields of the physics.

    Empty, so that the preset `carom` applies, if the engine's rolling friction can depend on speed;
    otherwise the rolling friction that was measured at a medium speed.
    """
    if has_feature(capabilities, Feature.QUADRATIC_ROLLING):
        return {}
    middle = facts_of("rolling-carom").rows[1].value
    return {"rolling_friction": middle / Physics().gravity, "rolling_friction_quadratic": 0.0}
