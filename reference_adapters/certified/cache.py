"""Certificates on the disk, named by a hash of the problem, the settings and the code.

A certificate depends on nothing else. A change of the source or of a library changes the name, so
no outdated certificate is found. The first line of a file is a hash of its name and of its content:
a damaged file, or a file with a wrong name, is removed and recomputed, with a one-line warning.
"""

from __future__ import annotations

import hashlib
import logging
import os
from contextlib import suppress
from fnmatch import fnmatch
from functools import cache
from pathlib import Path

import flint

from ghostball.model import GhostballError, rounding
from ghostball.model.cache_folder import cache_folder, last_use, note_use
from ghostball.model.text_files import write_whole
from ghostball.reference_adapters.certified.certificate import Certificate
from ghostball.reference_adapters.certified.problem import ExactProblem
from ghostball.reference_adapters.certified.settings import CertifiedSettings

logger = logging.getLogger("ghostball.certified")

MAX_CERTIFICATES = 1_000
"""Largest number of stored certificates; the least recently used ones are removed."""


def directory() -> Path:
    """Return the folder of the certificates."""
    return cache_folder("proofs")


def key_of(
    problem: ExactProblem, ids: tuple[str, ...], settings: CertifiedSettings, motion: bool
) -> str:
    """Return the name of a certificate; every bit of the doubles counts.

    The names of the balls are included, because the reason of a partial proof contains them.
    """
    digest = hashlib.sha256(code_hash().encode())
    # repr gives the shortest text that reads back to the same double.
    digest.update(repr((problem, ids, sorted(settings.model_dump().items()), motion)).encode())
    return digest.hexdigest()[:32]


@cache
def code_hash() -> str:
    """Return the hash of the sources of this package, the contact tolerances, and the library."""
    digest = hashlib.sha256()
    for path in [*sorted(Path(__file__).parent.glob("*.py")), Path(rounding.__file__)]:
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    digest.update(repr((flint.__version__, flint.__FLINT_VERSION__)).encode())
    return digest.hexdigest()


def path_of(key: str) -> Path:
    """Return the path of the certificate with a name."""
    return directory() / f"certificate-{key}.json"


def read(key: str) -> Certificate | None:
    """Return the certificate with a name, or None if there is no readable one."""
    path = path_of(key)
    try:
        seal, _, text = path.read_text("utf-8").partition("\n")
        if seal != _seal(key, text):
            raise GhostballError("it is damaged or misnamed")
        note_use(path)
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError, GhostballError) as error:
        logger.warning("%s can't be read; recomputing it: %s", path, error)
        with suppress(OSError):
            path.unlink(missing_ok=True)
        return None
    return Certificate.from_json(text)


def _seal(key: str, text: str) -> str:
    return hashlib.sha256(f"{key}\n{text}".encode()).hexdigest()


def write(key: str, certificate: Certificate) -> None:
    """Store a certificate; if this fails, log a warning and continue."""
    path = path_of(key)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        text = certificate.to_json()
        write_whole(path, f"{_seal(key, text)}\n{text}")
        _prune(path.parent)
    except OSError as error:
        logger.warning(
            "certificates can't be stored in %s: %s. Every run will recompute them. Set "
            "GHOSTBALL_CACHE_DIR to a writable folder",
            path.parent,
            error.strerror or type(error).__name__,
        )


def _prune(folder: Path) -> None:
    kept = [folder / name for name in os.listdir(folder) if fnmatch(name, "certificate-*.json")]
    # Most calls have nothing to remove, and needn't ask the system for the times of all files.
    if len(kept) > MAX_CERTIFICATES:
        for path in sorted(kept, key=last_use, reverse=True)[MAX_CERTIFICATES:]:
            path.unlink(missing_ok=True)  # a different process may have removed it
