"""The list of the laws of impacts."""

import subprocess
import sys


def test_knowing_the_laws_needs_no_compiler():
    check = "import sys, ghostball.engine; assert 'numba' not in sys.modules"
    subprocess.run([sys.executable, "-c", check], check=True)
