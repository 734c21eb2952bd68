"""Serve one engine: a scene per line in, its run per line out, all as JSON.

    PYTHON serve.py MODULE

Runs in the engine's interpreter, without ghostball; needs nothing but MODULE, which lies beside it
and has `version()` and `simulate(scene, record)`. That returns a run, or {"cannot": why} where the
engine can't represent the scene; `reference_adapters.workers.process` says what both are.
"""

import importlib
import json
import os
import sys
from typing import Any


def main() -> None:
    """Say hello, then answer until the input ends."""
    # Whatever the peer prints must not mix with the answers.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)

    def answer(value: dict[str, Any]) -> None:
        answers.write(json.dumps(value) + "\n")
        answers.flush()

    try:
        peer = importlib.import_module(sys.argv[1])
        answer({"version": peer.version()})
    except ImportError as error:
        answer({"absent": f"{type(error).__name__}: {error}"})
        return
    for line in sys.stdin:
        try:
            asked = json.loads(line)
            answer(peer.simulate(asked["scene"], asked["record"]))
        except Exception as error:
            answer({"error": f"{type(error).__name__}: {error}"})


if __name__ == "__main__":
    main()
