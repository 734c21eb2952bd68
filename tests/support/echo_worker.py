"""A worker that gives the same answer to every request."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from ghostball.reference_adapters.workers.process import Worker

ECHO = """
import json, sys
print(json.dumps({"version": "1"}), flush=True)
for line in sys.stdin:
    print(json.dumps(ANSWER), flush=True)
"""


def worker(folder: Path, answer: dict[str, Any]) -> Worker:
    script = folder / "echo.py"
    script.write_text(ECHO.replace("ANSWER", repr(answer)))
    return Worker([sys.executable, str(script)])
