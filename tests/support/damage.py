"""Valid input with one fault each, and checks of readers and commands that get such input."""

from __future__ import annotations

import json

from commands import cli

from ghostball.model import GhostballError

DEEP = "[" * 100_000
VALUES = (None, True, -1, 1e999, "x", "../../out", "\ud800", [], [[1.0], [1.0, 2.0]], {}, {"x": {}})
"""Values that replace a valid value."""

GONE = "gone"


def run(*arguments):
    result = cli(*arguments)
    return result.exit_code, result.output


def assert_refused_or_done(*arguments):
    """Run a command, which must finish or reject its input with a message of one line."""
    status, output = run(*arguments)
    assert status in (0, 1, 2, 4), output
    assert "Traceback" not in output
    if status == 2:
        assert output.count("error: ") == 1, output
    return status


def places(value, path=()):
    """Yield the path of each part of a value."""
    yield path
    if isinstance(value, list):
        value = dict(enumerate(value[:2]))  # only the first two elements of a list
    for key, part in value.items() if isinstance(value, dict) else ():
        yield from places(part, (*path, key))


def faults(whole, values=VALUES):
    """Yield copies of a value that each have one fault."""
    for path in places(whole):
        for put in (*values, GONE) if path else ():
            changed = json.loads(json.dumps(whole))
            at = changed
            for key in path[:-1]:
                at = at[key]
            if put is GONE:
                del at[path[-1]]
            else:
                at[path[-1]] = put
            yield changed


def texts(text):
    """Yield copies of a JSON text with one fault each, other JSON, and texts that aren't JSON."""
    yield from ("", "null", "[]", "{}", "no json", DEEP, text[: len(text) // 2])
    yield from map(json.dumps, faults(json.loads(text)))


def reads(read, path, text):
    """Return True if a file is read, and False if it is rejected with a `GhostballError`."""
    path.write_text(text, "utf-8", "surrogatepass")
    try:
        read(path)
    except GhostballError:
        return False
    return True
