"""The certificate of a scene, from the disk if it is stored, otherwise computed."""

from __future__ import annotations

import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from ghostball.model import Scene, UnsupportedSceneError
from ghostball.reference_adapters.certified import Certificate, CertifiedSettings, certify
from ghostball.reference_adapters.certified.api import check_certified

logger = logging.getLogger("ghostball.validation")

MESSAGE_DELAY = 3.0
"""Computing time [s] after which a message explains the wait."""


def certificate_of(
    scene: Scene, settings: CertifiedSettings | None = None
) -> tuple[Certificate | None, str]:
    """Return the certificate of a scene, with its motion; or None, and why it can't be certified.

    `settings`: limits of the computation.

    Certificates are stored on the disk. A message is logged if computing one takes long.
    """
    if why := refused_features(scene):
        return None, why
    with explained(
        f'certifying scene "{scene.name}" takes a while; the result is kept for the next run'
    ):
        return certify(scene, settings, motion=True), ""


def refused_features(scene: Scene) -> str:
    """Return the features of a scene that prevent certification, or ""."""
    try:
        check_certified(scene)
    except UnsupportedSceneError as error:
        return "; ".join(error.features)
    return ""


@contextmanager
def explained(message: str) -> Iterator[None]:
    """Log a message if the block takes longer than `MESSAGE_DELAY`."""
    timer = threading.Timer(MESSAGE_DELAY, logger.warning, (message,))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
