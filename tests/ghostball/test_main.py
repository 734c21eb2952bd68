"""The installed command and the module are the same."""

import subprocess
import sys
from pathlib import Path


def test_the_command_is_installed_and_is_the_module():
    command = Path(sys.executable).parent / "ghostball"
    for start in ([str(command)], [sys.executable, "-m", "ghostball"]):
        done = subprocess.run([*start, "--version"], capture_output=True, text=True, check=True)
        assert done.stdout.startswith("ghostball ")
