"""An adapter compiles its kernels before its run is timed."""

import subprocess
import sys

import pytest

# Run in a separate process, in which no earlier test has compiled these kernels.
CODE = """
import sys
from ghostball.engine.library.entry import Entry
from ghostball.reference_adapters.stepping import contact_time
from ghostball.reference_adapters.stepping import slowing as slowing_kernels
from ghostball.reference_adapters.recording import Recorder
from ghostball.reference_adapters import make_engine
from ghostball.validation.scenes.library import find_scene

kernels = {
    f"{module.__name__}.{name}": kernel
    for module in (contact_time, slowing_kernels)
    for name, kernel in vars(module).items()
    if isinstance(kernel, Entry)
}
assert len(kernels) > 8
before = {}
start, result = Recorder.start, Recorder.result

def started(self):
    before.update({name: set(kernel._by_kinds) for name, kernel in kernels.items()})
    start(self)

def ended(self, **arguments):
    for name, kernel in kernels.items():
        for kinds in set(kernel._by_kinds) - before[name]:
            print(f"{scene} compiles or loads {name} for {kinds}")
    return result(self, **arguments)

Recorder.start, Recorder.result = started, ended
engine = make_engine(sys.argv[1])
for scene in sys.argv[2:]:
    engine.simulate(find_scene(scene), record="trajectory")
"""


@pytest.mark.compiled
@pytest.mark.parametrize(
    ("spec", "scenes"),
    [
        (
            "pymunk:contact_steps=exact",
            ["stop", "break-7"],
        ),  # one ball, whose arrays are all contiguous
        ("pybullet:contact_steps=exact", ["break-7", "stop"]),
    ],
)
def test_no_kernel_is_compiled_while_a_run_is_timed(spec, scenes):
    # Fails for a memory layout that the warm-up doesn't have, and for a new kernel.
    if spec.startswith("pybullet"):
        pytest.importorskip("pybullet")
    done = subprocess.run(
        [sys.executable, "-c", CODE, spec, *scenes], capture_output=True, text=True, check=True
    )
    assert done.stdout == ""
