"""The impact laws: names, the fields of `Physics` that each law uses, and sources.

In Ghostball's engine, a law is a function in a file of `engine/impacts/laws/`, an entry here, and a
branch of `dispatch` there. A law's index in its tuple is its number in `dispatch`. Two
files contain two cushion laws: "frictional" is in `cushion_han2005`, "mirror" in
`cushion_restitution`.
"""

from __future__ import annotations

from typing import NamedTuple


class LawEntry(NamedTuple):
    """One law: its name in a scene, the fields of `Physics` that it uses, and its source."""

    name: str
    uses: tuple[str, ...]
    source: str
    feature: str | None = None
    """Name of the `model.features.Feature` that an engine needs for this law."""
    limits: tuple[tuple[str, float], ...] = ()
    """Pairs of a field and the largest value of the field for which the law is valid."""
    turns: bool = False
    """Whether the law always includes friction, which changes the spin of balls.

    Such a law requires `motion` = "sliding". `ball_friction` doesn't count here, because it may be
    0, and then the law doesn't change spin.
    """
    integrated: bool = False
    """Whether the law is a numerical integration over the impact.

    Such laws exclude airborne balls and impacts that last.
    """
    fitted: bool = True
    """Whether tracks of balls can determine the coefficients of the law."""


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
        # With far larger friction, the ball on the cloth could jam between the cloth and the other
        # ball and leave the cloth. Below 5/7, the cloth can't prevent slip, however strong the
        # normal force is: the slip passes through zero, and the ball never rolls during an impact.
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
        "the normal velocity is reversed (the paper, section 4.2)",
        feature="MIRROR_CUSHION",
    ),
    LawEntry(
        "restitution",
        (*_RESTITUTION, "cushion_tangential_restitution"),
        "constant factors on normal and tangential velocity; spin unchanged",
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
    LawEntry(
        "stronge2000",
        (*_RESTITUTION, "cushion_friction", "cushion_height", "cushion_frequency_ratio"),
        "restitution and friction at a nose that yields along the slip (Stronge 2000)",
        feature="STRONGE_CUSHION",
        turns=True,
        # Rolling balls slip during the whole contact with a cushion of usual friction. The results
        # are then those of "han2005" for any ratio of the frequencies.
        fitted=False,
    ),
)

BALL_LAW_NAMES = tuple(law.name for law in BALL_LAWS)
CUSHION_LAW_NAMES = tuple(law.name for law in CUSHION_LAWS)


def any_integrated(*names: str) -> bool:
    """Return whether one of the named laws is integrated over the impact."""
    return any(law.integrated for law in (*BALL_LAWS, *CUSHION_LAWS) if law.name in names)
