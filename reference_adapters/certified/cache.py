"""Certificates on the disk, named by a hash of the problem, the settings and the code.

What is proved depends on nothing else. A changed source or library means another name, so nothing
stale is ever found. The first line of a file is a hash of its name and of the rest of it: one that
is damaged, or isn't of that name, is removed and computed anew, with a warning of one line.
"""

from __future__ import annotations

import hashlib
import logging
import os
import tempfile
from contextlib import suppress
from functools import cache
from pathlib import Path

import flint

from ghostball.model import GhostballError, rounding
from ghostball.model.cache_folder import cache_folder
from ghostball.reference_adapters.certified.certificate import Certificate
from ghostball.reference_adapters.certified.problem import Problem
from ghostball.reference_adapters.certified.settings import CertifiedSettings

logger = logging.getLogger("ghostball.certified")

KEPT = 1_000
"""Certificates that are kept; the ones longest unused go first."""


def directory() -> Path:
    """Directory of the certificates."""
    return cache_folder("proofs")


def key_of(
    problem: Problem, ids: tuple[str, ...], settings: CertifiedSettings, motion: bool
) -> str:
    """Return the name of a certificate; doubles count with every bit.

    The names of the balls are in it because the reason of a partial proof names them.
    """
    digest = hashlib.sha256(code_hash().encode())
    # repr gives the shortest text that reads back to the same double.
    digest.update(repr((problem, ids, sorted(settings.model_dump().items()), motion)).encode())
    return digest.hexdigest()[:32]


@cache
def code_hash() -> str:
    """Hash of the sources of this package, of what counts as touching, and of the library."""
    digest = hashlib.sha256()
    for path in [*sorted(Path(__file__).parent.glob("*.py")), Path(rounding.__file__)]:
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    digest.update(repr((flint.__version__, flint.__FLINT_VERSION__)).encode())
    return digest.hexdigest()


def path_of(key: str) -> Path:
    """Return where a certificate of this name is kept."""
    return directory() / f"certificate-{key}.json"


def read(key: str) -> Certificate | None:
    """Return the certificate of this name, or None where there is none that can be read."""
    path = path_of(key)
    try:
        seal, _, text = path.read_text("utf-8").partition("\n")
        if seal != _seal(key, text):
            raise GhostballError("it is damaged, or of an older version")
        certificate = Certificate.from_json(text)
        os.utime(path)
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError, GhostballError) as error:
        logger.warning("%s can't be read and is computed anew: %s", path, error)
        with suppress(OSError):
            path.unlink(missing_ok=True)
        return None
    return certificate


def _seal(key: str, text: str) -> str:
    return hashlib.sha256(f"{key}\n{text}".encode()).hexdigest()


def write(key: str, certificate: Certificate) -> None:
    """Keep a certificate; where that can't be done, say so and continue."""
    path = path_of(key)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # Another process may read at any time: the file appears whole or not at all.
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=".certificate-")
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            text = certificate.to_json()
            file.write(f"{_seal(key, text)}\n{text}")
        Path(temporary).replace(path)
        _prune(path.parent)
    except OSError as error:
        logger.warning(
            "certificates can't be kept in %s: %s. Every run will compute them again; set "
            "GHOSTBALL_CACHE_DIR to a directory that can be written",
            path.parent,
            error.strerror or type(error).__name__,
        )


def _prune(folder: Path) -> None:
    kept = sorted(folder.glob("certificate-*.json"), key=_last_used, reverse=True)
    for path in kept[KEPT:]:
        path.unlink(missing_ok=True)  # another process may have been faster


def _last_used(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except FileNotFoundError:
        return 0.0
