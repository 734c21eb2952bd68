"""Compile the kernels of all shipped scenes for another machine, or simulate the scenes there.

`compile FOLDER` writes libraries into a folder, as in a wheel; GHOSTBALL_BUILD_FOR and CC select
the machine. `play` prints the hash of each scene's exact result.
"""

import sys
from pathlib import Path

from ghostball.engine import simulate
from ghostball.engine.needed_kernels import every_kernel
from ghostball.model.hashes import bits_hash
from ghostball.validation.scenes.library import select


def compile_into(folder: Path) -> None:
    sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
    from hatch_build import put_into

    put_into(folder, every_kernel())


def play() -> None:
    for scene in select():
        result = simulate(scene, record="events")
        assert result.events is not None
        print(scene.name, bits_hash(result.events, result.rest_positions), flush=True)


if __name__ == "__main__":
    if sys.argv[1] == "compile":
        compile_into(Path(sys.argv[2]))
    else:
        play()
