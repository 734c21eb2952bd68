"""The code on this machine: the sources of Ghostball and of engines, and the packages they use."""

from __future__ import annotations

import ast
import hashlib
import json
import os
import platform
import re
import sys
import sysconfig
from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import cache
from importlib.metadata import (
    Distribution,
    PackageNotFoundError,
    distributions,
    requires,
    version,
)
from importlib.util import find_spec
from inspect import getmodulename
from pathlib import Path
from typing import Any, Final

from ghostball.model import GhostballError
from ghostball.reference_adapters.capabilities import FILE as CAPABILITIES
from ghostball.reference_adapters.javascript import packages as javascript
from ghostball.reference_adapters.registry import (
    EngineUnavailableError,
    engine_class,
    parse_spec,
)
from ghostball.reference_adapters.workers.process import DISTRIBUTIONS, installed

OUR_PACKAGES = ("model", "engine", "reference_adapters", "validation")
"""Packages with code that may affect results."""

CODE_ENDINGS = (".py", ".mjs", ".html", ".so", ".pyd")
"""Endings of files with code, including templates. Scenes and criteria aren't code but inputs.

An engine's `capabilities.toml` counts as code, because it decides which scenes are unsupported and
how results are judged.
"""

LIBRARIES = (
    *("numpy", "numba", "llvmlite", "pymunk", "cffi", "pybullet"),
    *("mpmath", "gmpy2", "python-flint", "pydantic", "pydantic-core"),
    *("mujoco-core", "box2d", "dartpy", "sapien", "pyb2d3", "rapier3d", "newton", "warp-lang"),
)
"""Distributions that compute numbers, and their dependencies."""

PACKAGES = ("ghostball", *LIBRARIES)
"""Distributions with versions that can affect numbers."""

PACKAGE_OF: Final = {
    **dict.fromkeys(("certified", "paper-discrete", "paper-continuous"), "ghostball"),
    "mujoco": "mujoco-core",
    "box2d3": "pyb2d3",
    "dart": "dartpy",
    "physx": "sapien",
    "rapier": "rapier3d",
    "pooltool": "pooltool-billiards",
}
"""The key in `versions` of an engine of this project, if it isn't the name of the engine."""


class SourcesError(GhostballError):
    """Source files that can't be read, so changes can't be detected."""


def source_folders() -> tuple[Path, ...]:
    """Return the folders of Ghostball's packages, as they are imported.

    Raises `SourcesError` if a package isn't in a folder, for example in a zip archive.
    """
    folders = []
    for name in OUR_PACKAGES:
        spec = find_spec(f"ghostball.{name}")
        folder = Path(spec.origin).parent if spec is not None and spec.origin else None
        if folder is None or not code_files(folder):
            raise SourcesError(f"package `{name}`: its source files can't be found")
        folders.append(folder)
    return tuple(folders)


def hash_sources(folders: Iterable[Path]) -> str:
    """Return the hash of every file of code below `folders`: names, paths and contents.

    The path of an `__init__.py` stands for its folder; any other file is hashed alone.
    """
    digest = hashlib.sha256()
    for one in folders:
        folder = one.parent if one.is_file() else one
        for path in [one] if one.is_file() and one.stem != "__init__" else code_files(folder):
            content = path.read_bytes()
            head = [folder.name, path.relative_to(folder).as_posix(), len(content)]
            digest.update(json.dumps(head).encode() + content)
    return digest.hexdigest()


def code_files(folder: Path) -> list[Path]:
    """Return the files of code below a folder, sorted."""
    found = [
        os.path.join(inside, name)  # ten times as fast as `Path.rglob`
        for inside, _, names in os.walk(folder)
        for name in names
        if name.endswith(CODE_ENDINGS) or name == CAPABILITIES
    ]
    return [Path(path) for path in sorted(found)]


def versions() -> dict[str, str | None]:
    """Return the versions of `PACKAGES` and of the workers' engines; None: not installed."""
    there = {**installed(), **javascript.installed()}
    others = (*DISTRIBUTIONS, javascript.NODE, *javascript.PACKAGES)
    return {name: version_of(name) for name in PACKAGES} | {
        name: there.get(name) for name in others
    }


@cache  # reading metadata takes milliseconds, and every results folder needs it
def version_of(package: str) -> str | None:
    """Return the version of a distribution; None if it isn't installed."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def code_here() -> dict[str, str]:
    """Return values that are equal on two machines if they run the same code: hashes and versions.

    For the interpreter of the workers, the versions of all its packages count, because the
    dependencies of an engine may affect its numbers.
    """
    ours = {name: version_of(name) for name in PACKAGES}
    there = {**installed(), **javascript.installed()}
    theirs = {f"{name} of the workers": found for name, found in there.items()}
    return {
        "ghostball's sources": hash_sources(source_folders())[:12],
        "Python": platform.python_version(),
    } | {name: found for name, found in (ours | theirs).items() if found is not None}


def is_ours(label: str) -> bool:
    """Return True if an engine belongs to this project, so `code_here` covers its code."""
    engine: Any = engine_class(parse_spec(label)[0])
    return str(engine.__module__).startswith(tuple(f"ghostball.{name}." for name in OUR_PACKAGES))


def code_kind(label: str) -> str:
    """Return "" for an engine of this project, else the engine's name.

    The engines of this project share their processes. An engine of another project may change
    anything in its process, so it gets separate processes; see `pool.run_tasks`.
    """
    name, _ = parse_spec(label)
    try:
        return "" if is_ours(label) else name
    except EngineUnavailableError:
        return name


def engine_code(name: str) -> dict[str, str]:
    """Return the identity of an engine's code: the hash of its sources, and package versions.

    `name`: `NAME` or `MODULE:NAME` of an engine of another project; "" returns {}.

    The sources are all files of code of the engine's package or module, and of the modules that
    these import, except for installed distributions. The versions are those of the distributions
    that they import, and of the requirements of these. Data files, such as tables that an engine
    reads, don't count.

    Raises `EngineUnavailableError` if the engine can't be imported; `SourcesError` if its code is
    in no file.
    """
    if not name:
        return {}
    module = str(engine_class(name).__module__)
    files, distributions = _imported_by(module.partition(".")[0])
    if not files:
        raise SourcesError(f"engine `{name}`: module `{module}` has no source file")
    digest = hashlib.sha256()
    for relative, path in sorted(files.items()):
        content = path.read_bytes()
        digest.update(json.dumps([relative, len(content)]).encode() + content)
    found = {one: version_of(one) for one in sorted(distributions)}
    return {engine_source(name): digest.hexdigest()[:12]} | {
        one: number for one, number in found.items() if number is not None
    }


def engine_source(name: str) -> str:
    """Return the name of an engine's source in a comparison of code."""
    return f"the source of engine `{name}`"


def _imported_by(module: str) -> tuple[dict[str, Path], set[str]]:
    """Return the code that a top-level module imports, directly or indirectly.

    That is: the files of the module and of imports that aren't installed, keyed by their paths
    relative to the folder of import; and the names of the distributions of installed imports.
    """
    installed_in = [Path(sysconfig.get_path(one)).resolve() for one in ("purelib", "platlib")]
    # Folders without metadata, such as the current one, change from run to run.
    owners = _owners(tuple(one for one in sys.path if any(Path(one).glob("*-info"))))
    files: dict[str, Path] = {}
    needed: set[str] = set()
    names = [module]
    for name in names:  # the list grows in the loop
        if name in sys.stdlib_module_names or name == "ghostball":
            continue
        needed.update(*(_required(one.metadata["Name"]) for one in owners.get(name, ())))
        is_installed = any(
            path.resolve().is_relative_to(folder)
            for path in _paths_of(name)
            for folder in installed_in
        )
        if is_installed and name != module:
            continue
        own = dict(_files_of(name))
        files |= own
        code = [path for path in own.values() if path.suffix == ".py"]
        imported = {one for path in code for one in _imports(path.read_bytes())}
        names += sorted(imported.difference(names))
    return files, needed


def _files_of(name: str) -> Iterator[tuple[str, Path]]:
    """Yield the files of code of a top-level module or package, each with its relative path."""
    for path in _paths_of(name):
        if path.is_file():
            yield path.name, path
            continue
        for file in code_files(path):
            yield f"{name}/{file.relative_to(path).as_posix()}", file


def _paths_of(name: str) -> list[Path]:
    """Return the folders of a top-level package, or the file of a module; empty if it has none."""
    try:
        spec = find_spec(name)
    except (ImportError, ValueError):  # ValueError: a module that was created, not imported
        return []
    if spec is None:
        return []
    if spec.submodule_search_locations:
        return [Path(folder) for folder in spec.submodule_search_locations]
    return [Path(spec.origin)] if spec.origin and Path(spec.origin).is_file() else []


@cache  # a process asks for the code of an engine several times
def _imports(code: bytes) -> frozenset[str]:
    """Return the top-level names that Python code imports, anywhere in it."""
    try:
        tree = ast.parse(code)
    except (SyntaxError, ValueError):  # running the file will report it
        return frozenset()
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found.update(one.name.partition(".")[0] for one in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found.add(node.module.partition(".")[0])
    return frozenset(found)


@cache  # reads the file lists of all distributions
def _owners(path: tuple[str, ...]) -> Mapping[str, list[Distribution]]:
    """Return the distributions that own each top-level module found on a path.

    `importlib.metadata.packages_distributions` finds the same owners, but takes several times as
    long, because this function makes an object of each file and reads all metadata.
    """
    owners: dict[str, list[Distribution]] = {}
    for one in distributions(path=list(path)):
        for module in _modules_of(one):
            owners.setdefault(module, []).append(one)
    return owners


_TOP = re.compile(r"^([^/,\n]+)(/?)", re.MULTILINE)
"""The first part of each path in a list of files, and a slash if more parts follow."""


def _modules_of(distribution: Distribution) -> Collection[str]:
    """Return the names of the top-level modules and packages of a distribution."""
    declared = (distribution.read_text("top_level.txt") or "").split()
    if declared:
        return declared
    record = distribution.read_text("RECORD")
    if record is None:
        record = "\n".join(map(str, distribution.files or ()))
    # A path in quotes contains a comma or a quote, and no module's name contains one.
    tops = set(_TOP.findall(record))
    names = {top if slash else getmodulename(top) for top, slash in tops}
    return {name for name in names if name and "." not in name}


@cache
def _required(distribution: str) -> frozenset[str]:
    """Return a distribution and all its installed requirements, direct and indirect."""
    names = [distribution]
    for name in names:  # the list grows in the loop
        try:
            needed = requires(name) or ()
        except PackageNotFoundError:
            continue
        for one in needed:
            # Old packages state versions that `packaging` refuses: "PyYAML (>=5.1.*)".
            found = re.match(r"[A-Za-z0-9._-]+", one)
            if found is not None and found[0] not in names:
                names.append(found[0])
    return frozenset(names)
