"""Builds the wheel with the engine's kernels in it, compiled: who installs it compiles nothing.

Only where GHOSTBALL_BUILD_KERNELS=1 is in the environment, as for the wheels of a release: all of
them take ten minutes of the processor. Without, a wheel has none, and is for every platform; each
kernel is then compiled where it is first needed, by the extra `compiler`.
"""

from __future__ import annotations

import json
import os
import platform
import shutil
import sys
import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

ASKED = "GHOSTBALL_BUILD_KERNELS"

IMPORTED = ("numpy", "pydantic", "tomli-w", "platformdirs", "filelock", "lazy-loader")
"""What the modules of the kernels import, of what ghostball depends on."""

INSIDE = "ghostball/engine/library/shipped"
"""Where the libraries lie in the wheel."""


class KernelHook(BuildHookInterface[Any]):
    """Compiles each kernel that a scene may need, and adds its library to the wheel."""

    def dependencies(self) -> list[str]:
        """Return what compiling needs in the environment in which the wheel is built."""
        if not self.is_asked:
            return []
        project = self.metadata.core
        imported = [one for one in project.dependencies if one.startswith(IMPORTED)]
        return [*imported, *project.optional_dependencies["compiler"]]

    @property
    def is_asked(self) -> bool:
        """Whether the wheel gets kernels."""
        return os.environ.get(ASKED, "0") not in ("", "0")

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile, and say for which platform the wheel is."""
        if version == "editable" or not self.is_asked:  # edits would set them aside
            return
        if os.environ.get("GHOSTBALL_BUILD_FOR"):
            raise RuntimeError(
                "a wheel is built on the machine it is for: unset GHOSTBALL_BUILD_FOR"
            )
        folder = Path(self.directory, "kernels")
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        sys.path.insert(0, self.root)
        compile_into(folder)
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{platform_tag()}"
        for path in folder.iterdir():
            build_data["force_include"][str(path)] = f"{INSIDE}/{path.name}"


def compile_into(folder: Path) -> None:
    """Put a library of each kernel in a folder, and the manifest beside them."""
    from ghostball.engine.needed_kernels import every_kernel  # noqa: PLC0415 - of the sources here
    from ghostball.reference_adapters.stepping.kernels import KERNELS  # noqa: PLC0415

    put_into(folder, [*every_kernel(), *(one for kernels in KERNELS.values() for one in kernels())])


def put_into(folder: Path, needed: list[Any]) -> None:
    """Put the libraries of some kernels, `Needed`, in a folder, and the manifest beside them."""
    from ghostball.engine.library import load, shipped  # noqa: PLC0415
    from ghostball.engine.library.entry import make_all  # noqa: PLC0415

    if shipped.flags():
        raise RuntimeError(f"a wheel's kernels need the environment without {[*shipped.flags()]}")

    folder.mkdir(parents=True, exist_ok=True)
    make_all(needed, os.cpu_count() or 1)
    files = {}
    for one in needed:
        kernel = one.kernel.function
        path = load.find(kernel, one.kinds)
        if path is None or path.suffix != ".so":
            raise RuntimeError("a C compiler is needed to link the kernels; name it in CC")
        shutil.copy(path, folder)
        files[shipped.key_of(kernel, one.kinds)] = path.name
    text = json.dumps(shipped.manifest(files), indent=1)
    (folder / shipped.MANIFEST).write_text(text + "\n", encoding="utf-8")


def platform_tag() -> str:
    """Return the platform of the wheel, in the words of wheels.

    The libraries take nothing of Linux's C library but functions of mathematics that any version
    has, so that no older one is too old; of another C library than glibc nothing is promised. A
    Python for both machines of macOS compiles for one of them.
    """
    system, _, rest = sysconfig.get_platform().partition("-")
    if system == "macosx":
        oldest = os.environ.get("MACOSX_DEPLOYMENT_TARGET", "11.0")
        rest = f"{oldest}-{platform.machine()}"
    elif system == "linux" and platform.libc_ver()[0] == "glibc":
        system = "manylinux_2_17"
    return f"{system}-{rest}".replace("-", "_").replace(".", "_")
