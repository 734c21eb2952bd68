"""The proof of a scene for the suite: from the disk where it was proved before, else computed."""

from __future__ import annotations

import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from ghostball.model import Scene, UnsupportedSceneError
from ghostball.reference_adapters.certified import Certificate, CertifiedSettings, certify
from ghostball.reference_adapters.certified.api import check_certified

logger = logging.getLogger("ghostball.validation")

PATIENCE = 3.0
"""Seconds of computing after which it is said what takes so long."""


def proof_of(
    scene: Scene, settings: CertifiedSettings | None = None
) -> tuple[Certificate | None, str]:
    """Return what is proved of a scene, with its motion; or None and why it can't be proved.

    `settings`: how far the proof may go.

    A proof is kept on the disk; where it takes long to compute, a message says so meanwhile.
    """
    if why := refused_features(scene):
        return None, why
    with explained(
        f'proving scene "{scene.name}" in ball arithmetic takes a while; the proof is kept for '
        "the next run"
    ):
        return certify(scene, settings, motion=True), ""


def refused_features(scene: Scene) -> str:
    """Return what of a scene can't be proved, or ""."""
    try:
        check_certified(scene)
    except UnsupportedSceneError as error:
        return "; ".join(error.features)
    return ""


@contextmanager
def explained(message: str) -> Iterator[None]:
    """Log a message once the block has taken longer than `PATIENCE`."""
    timer = threading.Timer(PATIENCE, logger.warning, (message,))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
