"""What is right of a shot on the board: its end as it is proved, by nothing that stands there."""

from __future__ import annotations

from ghostball.engine import GhostballError, Result, Scene
from ghostball.reference_adapters.certified import CertifiedSettings
from ghostball.reference_adapters.certified.engine import result_of
from ghostball.validation.truth.proof import proof_of


def proved_end(scene: Scene) -> Result:
    """Return the end of a shot: proved in ball arithmetic, and rounded to the nearest doubles.

    Raises
    ------
    GhostballError
        Where not the whole shot is proved. No engine stands in for the proof: ours is one of those
        that are measured.
    """
    proof, why = proof_of(scene)
    if proof is None or not proof.proved:
        why = why if proof is None else f"{proof.ending}: {proof.reason}"
        raise GhostballError(
            f'scene "{scene.name}": a shot of the board must be proved to its end, got: {why}. '
            "Choose another scene for the column"
        )
    return result_of(scene, proof, CertifiedSettings(), "rest")
