"""Serve one engine: a scene per line in, its result per line out, as JSON.

    PYTHON serve.py MODULE

The script runs in the engine's interpreter, without ghostball. It needs only MODULE, a file in this
folder with `version()` and `simulate(scene, record)`. The latter returns a result, or
{"cannot": reason} if the engine doesn't support the scene; see
`reference_adapters.workers.process`.
"""

import importlib
import json
import os
import sys
from typing import Any


def main() -> None:
    """Print the version, then answer until the input ends."""
    # Output of the engine must not mix with the answers.
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
