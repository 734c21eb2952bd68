"""Serve one peer: a scene per line in, what it gave per line out, all as JSON.

    PYTHON serve.py MODULE

Runs in the peer's interpreter, without ghostball; needs nothing but MODULE, which lies beside it
and has `version()` and `simulate(scene)`. That returns {"seconds", "events"}, or {"cannot": why}
where the peer can't represent the scene.
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
            answer(peer.simulate(json.loads(line)))
        except Exception as error:
            answer({"error": f"{type(error).__name__}: {error}"})


if __name__ == "__main__":
    main()
