"""Compiles the kernels of all shipped scenes for another machine, or plays the scenes there.

`compile FOLDER` puts libraries into a folder, as a wheel has them; GHOSTBALL_BUILD_FOR and CC say
for which machine. `play` prints the hash of each scene's bits.
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
