"""The impact laws: their names, what each uses, and where it comes from.

In our engine a law is a function in a file of `engine/impacts/laws/`, its entry here, and its
branch in `dispatch` there; its place in its tuple is its code. A file may have two: the cushions'
"frictional" is in `cushion_han2005`, "mirror" in `cushion_restitution`.
"""

from __future__ import annotations

from typing import NamedTuple


class LawEntry(NamedTuple):
    """One law: its name in a scene, the fields of `Physics` that it uses, its source."""

    name: str
    uses: tuple[str, ...]
    source: str
    feature: str | None = None
    """What other engines must be able to do for it: a name of `model.features.Feature`."""
    limits: tuple[tuple[str, float], ...] = ()
    """Fields that it uses, each with the largest value up to which it describes balls."""
    turns: bool = False
    """Whether it turns balls, by friction that is part of it: spin must be a state of its own.

    `ball_friction` is no such part: it may be 0, and then a law leaves spin alone.
    """
    integrated: bool = False
    """Whether it integrates over the impact: such laws are compiled only where a scene has one."""


BALL_LAWS = (
    LawEntry(
        "frictional",
        ("ball_restitution", "ball_friction"),
        "restitution and Coulomb friction (Wallace and Schroeder 1988; Alciatore, proof A.14)",
    ),
    LawEntry(
        "mathavan2014",
        ("ball_restitution", "ball_friction", "sliding_friction"),
        "integrated over the impulse, with the friction of the cloth (Mathavan et al. 2014)",
        feature="MATHAVAN_BALL",
        # Far above, the ball on the cloth could jam between it and the other, and wouldn't stay
        # on it. Below 5/7 the cloth can't keep the ball from slipping however strongly it is
        # there: so its slip passes through zero, and it never rolls during an impact.
        limits=(("ball_friction", 1.0), ("sliding_friction", 0.7)),
        turns=True,
        integrated=True,
    ),
)

_RESTITUTION = ("cushion_restitution", "cushion_restitution_loss")

CUSHION_LAWS = (
    LawEntry(
        "mirror",
        (),
        "the normal velocity changes sign (the paper, section 4.2)",
        feature="MIRROR_CUSHION",
    ),
    LawEntry(
        "restitution",
        (*_RESTITUTION, "cushion_tangential_restitution"),
        "factors on the normal and the tangential velocity; spin untouched",
        feature="CUSHION_RESTITUTION",
    ),
    LawEntry(
        "frictional",
        (*_RESTITUTION, "cushion_friction"),
        "restitution and Coulomb friction at the height of the ball's centre",
        feature="FRICTIONAL_CUSHION",
        turns=True,
    ),
    LawEntry(
        "han2005",
        (*_RESTITUTION, "cushion_friction", "cushion_height"),
        "restitution and Coulomb friction at the height of the nose (Han 2005)",
        feature="HAN_CUSHION",
        turns=True,
    ),
    LawEntry(
        "mathavan2010",
        (*_RESTITUTION, "cushion_friction", "cushion_height", "sliding_friction"),
        "integrated over the impulse, with the friction of the cloth (Mathavan et al. 2010)",
        feature="MATHAVAN_CUSHION",
        turns=True,
        integrated=True,
    ),
)

BALL_LAW_NAMES = tuple(law.name for law in BALL_LAWS)
CUSHION_LAW_NAMES = tuple(law.name for law in CUSHION_LAWS)


def any_integrated(*names: str) -> bool:
    """Whether one of the laws of these names integrates over the impact."""
    return any(law.integrated for law in (*BALL_LAWS, *CUSHION_LAWS) if law.name in names)
