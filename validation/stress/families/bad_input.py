"""Bad input: every malformed scene is refused by name, and a NaN that comes up is found."""

from __future__ import annotations

import json
import math
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from engine import Scene
from reference_adapters import ReferenceEngine
from validation.leash import leashed
from validation.stress.commands import ended, ghostball
from validation.stress.family import Family
from validation.stress.not_finite import COLUMNS, SHOTS, UNCHECKED, Overflow, Planted, Unchecked
from validation.stress.refusals import (
    check_anything,
    check_cut,
    check_malformed,
    check_refused,
    check_syntax,
    check_well_formed,
    refusal_of,
    search,
    told,
)
from validation.stress.trial import Suite, Trial, Verdict

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy


@dataclass(frozen=True)
class Generated(Trial):
    """Malformed scenes of one kind: each is refused, and told by field, rule, value and place.

    Attributes
    ----------
    name : str
    kind : str
        A kind of mistake, as in `malformed.MISTAKES`; or "syntax", "cut", "anything",
        "well-formed".
    count : int
    """

    name: str
    kind: str
    count: int
    small: ClassVar[bool] = False  # no kernel has a part in it

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Try it."""
        from validation.stress import bad_files, malformed  # noqa: PLC0415
        from validation.stress.plain_scenes import well_formed  # noqa: PLC0415

        texts: dict[str, tuple[SearchStrategy[Any], Callable[[Any], tuple[str, ...]]]] = {
            "syntax": (bad_files.bad_syntax(), check_syntax),
            "cut": (bad_files.cut_text(), check_cut),
            "anything": (bad_files.ANYTHING, check_anything),
            "well-formed": (well_formed(), partial(check_well_formed, engine=engine)),
        }
        if self.kind in texts:
            strategy, check = texts[self.kind]
            return search(strategy, check, self.count)
        return search(malformed.malformed(self.kind), check_malformed, self.count)


def odd_files(folder: Path) -> Iterator[tuple[str, Path, str]]:
    """Make files that are no scenes, in a folder; yield what each is, its path, and what to say."""

    def file(name: str, content: bytes) -> Path:
        path = folder / name
        path.write_bytes(content)
        return path

    good = b'schema = 1\nname = "a"\n[[balls]]\nid = "cue"\nposition = [0.0, 0.0]\n'
    yield "a file that isn't there", folder / "none.toml", "can't read"
    yield "a folder", folder, "can't read"
    yield "a path that no file can have", folder / "a\0b", "can't read"
    yield "an empty file", file("empty.toml", b""), "`schema` must be given"
    yield "Latin-1", file("latin.toml", good.replace(b'"cue"', b'"k\xf6"')), "not UTF-8"
    yield "half a character", file("half.toml", good + "# ö".encode()[:-1]), "not UTF-8"
    yield "UTF-16", file("utf16.toml", good.decode().encode("utf-16")), "not UTF-8"
    yield "a byte order mark", file("bom.toml", b"\xef\xbb\xbf" + good), "not valid TOML"
    yield "zeros", file("zeros.toml", bytes(10_000)), "not valid TOML"
    yield "brackets", file("deep.toml", b"a = " + b"[" * 100_000), "nested too deeply"
    yield "tables", file("wide.toml", good + b"[" + b"a." * 5_000 + b"a]\n"), "not a known field"
    yield "digits", file("digits.toml", b"t_max = 1" + b"0" * 5_000 + b"\n" + good), "digits"
    yield "a word", file("word.toml", b"x" * 1_000_000), "not valid TOML"
    many = b"".join(b'[[balls]]\nid = "%d"\nposition = [0, nan]\n' % i for i in range(1_000))
    yield "a mistake 1000 times", file("many.toml", good + many), "980 more mistakes"
    heap = b"".join(b'[[balls]]\nid = "%d"\nposition = [0, 0]\n' % i for i in range(1_000))
    yield "1000 balls at one place", file("heap.toml", good + heap), "must not overlap"
    if Path("/dev/zero").exists():
        yield "a device without end", Path("/dev/zero"), "a scene must have at most"


@dataclass(frozen=True)
class OddFiles(Trial):
    """Files that no generator comes upon: none is read for ever."""

    name: str
    small: ClassVar[bool] = False

    def run(self, engine: ReferenceEngine) -> Verdict:  # noqa: ARG002 - about reading alone
        """Try it."""
        faults: list[str] = []
        tried = broken = 0
        with tempfile.TemporaryDirectory() as folder:
            for what, path, says in odd_files(Path(folder)):
                message, wrong = refusal_of(partial(Scene.load, path), what)
                wrong = wrong or told(message, (says,), what)
                tried, broken = tried + 1, broken + bool(wrong)
                faults += wrong
        return Verdict(tuple(faults), None, float(bool(faults)), tried, broken)


@dataclass(frozen=True)
class CommandLine(Trial):
    """`ghostball simulate FILE` on malformed files: exit status 2, one message, no traceback.

    Attributes
    ----------
    name : str
    count : int
        Of each kind of mistake.
    """

    name: str
    count: int
    limit: ClassVar[float] = 300.0
    small: ClassVar[bool] = False

    def run(self, engine: ReferenceEngine) -> Verdict:  # noqa: ARG002 - about the command
        """Try it."""
        texts = [text for kind in _KINDS for text in _examples(kind, self.count)]
        faults, broken = [], 0
        with tempfile.TemporaryDirectory() as folder:
            paths = []
            for k, text in enumerate(texts):
                paths.append(Path(folder) / f"{k}.toml")
                paths[-1].write_text(text, encoding="utf-8")
            paths.append(Path(folder) / "none.toml")
            for path, (status, output, errors) in zip(paths, simulate_files(paths), strict=True):
                wrong = check_refused(path, status, output, errors)
                broken += bool(wrong)
                faults += wrong
        return Verdict(tuple(faults), None, float(bool(faults)), len(paths), broken)


_SIMULATE = """
import contextlib, io, json, sys
from ghostball.cli import app
from validation.leash import end_with_input

end_with_input()

# The files of one process: to start one for each takes longer than all of them.
for path in sys.argv[1:]:
    out, err = io.StringIO(), io.StringIO()
    status = None
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            app(["simulate", path])
        except SystemExit as error:
            status = error.code
    print(json.dumps([status, out.getvalue(), err.getvalue()]))
"""


def simulate_files(paths: list[Path]) -> list[tuple[int, str, str]]:
    """Return exit status, output and messages of `ghostball simulate` on each of the files.

    The first one has a process of its own.
    """
    first, *others = map(str, paths)
    alone = ended(ghostball(["simulate", first]), _PATIENCE)
    found: list[tuple[int, str, str]] = [(alone.status, alone.output, alone.errors)]
    if others:
        together = ended(leashed([sys.executable, "-c", _SIMULATE, *others]), _PATIENCE)
        found += [tuple(json.loads(line)) for line in together.output.split("\n")[:-1]]
        missing = len(paths) - len(found)
        if missing:  # the process ended within the next file, or began none at all
            found.append((together.status, "", f"it dies: {together.errors[-1000:]}"))
            found += simulate_files(paths[len(found) :]) if missing > 1 else []
    return found


def _examples(kind: str, count: int) -> list[str]:
    """Return malformed scenes of a kind, as text."""
    from validation.stress.bad_files import bad_syntax  # noqa: PLC0415
    from validation.stress.malformed import malformed  # noqa: PLC0415

    texts: list[str] = []

    def keep(case: Any) -> tuple[str, ...]:
        text = case[0] if kind == "syntax" else case.text()[0]
        if kind == "syntax" or case.plain:
            texts.append(text)
        return ()

    search(bad_syntax() if kind == "syntax" else malformed(kind), keep, 4 * count)
    return texts[:: max(len(texts) // count, 1)][:count]


_PATIENCE = 140.0
"""Seconds after which commands that should have ended hang; each of two waits once."""

_KINDS = ("numbers", "choices", "types", "missing", "unknown", "relations", "syntax")


def _trials(suite: Suite) -> Iterator[Trial]:
    full = suite == "full"
    examples = 1_000 if full else 50
    for kind in (*_KINDS, "cut", "anything", "well-formed"):
        yield Generated(kind, kind, examples)
    yield OddFiles("odd-files")
    yield CommandLine("command-line", 20 if full else 2)
    for physics in UNCHECKED:
        for count in (3, 120):
            for value in (math.nan, math.inf, -math.inf) if full else (math.nan, math.inf):
                yield Unchecked(f"unchecked-{physics}-{count}-{value}", physics, count, value)
        yield Overflow(f"overflow-{physics}", physics)
    for physics in SHOTS:
        for column in COLUMNS:
            yield Planted(f"planted-{physics}-{column.lower()}", physics, column)


FAMILY = Family(
    "bad-input",
    "Malformed scenes and NaN",
    "Every malformed scene, as plain values, as text or as a file, is refused with an error that "
    "names field, rule, value and place; none crashes, hangs or is half run, nor is a valid one "
    "refused; so is one made past the checks. A NaN that comes up in a run ends it there, named.",
    _trials,
    ours_alone=True,
)
