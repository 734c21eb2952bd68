"""Build hook that adds the engine's compiled kernels to the wheel.

It acts only if the environment has GHOSTBALL_BUILD_KERNELS=1, as for the wheels of a release:
compiling all kernels takes ten minutes of processor time. Otherwise the wheel has no kernels, and
suits every platform. Each kernel is then compiled on first use, which needs the extra `compiler`.
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

SWITCH = "GHOSTBALL_BUILD_KERNELS"
"""Environment variable that switches the hook on."""

KERNEL_DEPENDENCIES = ("numpy", "pydantic", "tomli-w", "platformdirs", "filelock", "lazy-loader")
"""Dependencies of ghostball that the modules of the kernels import."""

LIBRARY_FOLDER = "ghostball/engine/library/shipped"
"""Folder of the libraries in the wheel."""


class KernelHook(BuildHookInterface[Any]):
    """Hook that compiles each kernel that a scene may need, and adds its library to the wheel."""

    def dependencies(self) -> list[str]:
        """Return the packages that compiling needs in the build environment."""
        if not self.is_asked:
            return []
        project = self.metadata.core
        imported = [one for one in project.dependencies if one.startswith(KERNEL_DEPENDENCIES)]
        return [*imported, *project.optional_dependencies["compiler"]]

    @property
    def is_asked(self) -> bool:
        """Whether the environment asks for kernels in the wheel."""
        return os.environ.get(SWITCH, "0") not in ("", "0")

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile the kernels, and set the platform tag of the wheel."""
        if version == "editable" or not self.is_asked:  # edits would make the kernels outdated
            return
        if os.environ.get("GHOSTBALL_BUILD_FOR"):
            raise RuntimeError(
                "a wheel with kernels must be built on its own platform: unset GHOSTBALL_BUILD_FOR"
            )
        folder = Path(self.directory, "kernels")
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        sys.path.insert(0, self.root)
        compile_into(folder)
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{platform_tag()}"
        for path in folder.iterdir():
            build_data["force_include"][str(path)] = f"{LIBRARY_FOLDER}/{path.name}"


def compile_into(folder: Path) -> None:
    """Write a library of each kernel, and the manifest, into a folder."""
    from ghostball.engine.needed_kernels import every_kernel  # noqa: PLC0415 - from these sources
    from ghostball.reference_adapters.stepping.kernels import KERNELS  # noqa: PLC0415

    put_into(folder, [*every_kernel(), *(one for kernels in KERNELS.values() for one in kernels())])


def put_into(folder: Path, needed: list[Any]) -> None:
    """Write the libraries of the kernels in `needed`, and the manifest, into a folder.

    Raises `RuntimeError` if the environment has variables that change kernels, or if there is no C
    compiler.
    """
    from ghostball.engine.library import load, shipped  # noqa: PLC0415
    from ghostball.engine.library.entry import make_all  # noqa: PLC0415

    if shipped.flags():
        raise RuntimeError(
            "kernels for a wheel must be compiled without the environment variables "
            f"{', '.join(shipped.flags())}"
        )

    folder.mkdir(parents=True, exist_ok=True)
    make_all(needed, os.cpu_count() or 1)
    files = {}
    for one in needed:
        kernel = one.kernel.function
        path = load.find(kernel, one.kinds)
        if path is None or path.suffix != ".so":
            raise RuntimeError("linking the kernels needs a C compiler: set CC to its name")
        shutil.copy(path, folder)
        files[shipped.key_of(kernel, one.kinds)] = path.name
    text = json.dumps(shipped.manifest(files), indent=1)
    (folder / shipped.MANIFEST).write_text(text + "\n", encoding="utf-8")


def platform_tag() -> str:
    """Return the platform tag of the wheel.

    On Linux the libraries use only mathematical functions that every version of glibc has, so the
    tag is that of an old glibc. With another C library, the tag promises nothing. On macOS a
    universal Python compiles only for the processor of this machine.
    """
    system, _, rest = sysconfig.get_platform().partition("-")
    if system == "macosx":
        oldest = os.environ.get("MACOSX_DEPLOYMENT_TARGET", "11.0")
        rest = f"{oldest}-{platform.machine()}"
    elif system == "linux" and platform.libc_ver()[0] == "glibc":
        system = "manylinux_2_17"
    return f"{system}-{rest}".replace("-", "_").replace(".", "_")
