"""Files of users: no command waits forever, a byte order mark isn't text, no file is partial."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from threading import Timer

import pytest
from damage import run

from ghostball.model import Scene, SceneError
from ghostball.model.text_files import read_bytes, read_text, write_whole

SCENE = 'schema = 1\nname = "scene"\n[[balls]]\nid = "b"\nposition = [0.5, 0.5]\n'

pipes = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="named pipes are POSIX")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Work in a folder with a named pipe at every path that a command reads."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("ghostball.validation.parallel.pool.limit_of", lambda _: None)
    (tmp_path / "scene.toml").write_text(SCENE, encoding="utf-8-sig")
    (tmp_path / "baselines" / "ghostball").mkdir(parents=True)
    for name in ("pipe.toml", "scene.expect.toml", "baselines/ghostball/stop.json"):
        os.mkfifo(tmp_path / name)
    return tmp_path


def test_a_byte_order_mark_and_other_ends_of_lines_are_no_part_of_a_text(tmp_path: Path) -> None:
    path = tmp_path / "text"
    path.write_bytes(b"\xef\xbb\xbfa\r\nb\rc\n")
    assert read_text(path) == "a\nb\nc\n"
    assert read_bytes(path, 4) == b"\xef\xbb\xbfa"


@pipes
def test_a_named_pipe_is_refused_at_once(here: Path) -> None:
    # A named pipe has no end until a process writes to it, so a command would wait forever.
    assert Scene.load(here / "scene.toml").name == "scene"
    with pytest.raises(OSError, match="it is a named pipe and must be a file"):
        read_text(here / "pipe.toml")
    with pytest.raises(SceneError, match="it is a named pipe and must be a file"):
        Scene.load(here / "pipe.toml")


@pipes
@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(
    ("command", "status"),
    [
        (("run", "pipe.toml"), 2),
        (("grade", "pipe.toml"), 1),  # the engine left an incomplete run
        (("fit", "pipe.toml", "--table", "3.0", "1.5", "--radius", "0.03"), 2),
        (("validate", "scene.toml", "--no-report"), 2),
        (("regress", "stop", "--baselines", "baselines"), 2),
    ],
    ids=lambda one: one[0] if isinstance(one, tuple) else None,
)
def test_no_command_waits_for_a_named_pipe(command: tuple[str, ...], status: int) -> None:
    found, output = run(*command)
    assert found == status, output
    assert "it is a named pipe and must be a file" in output


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="needs /proc")
@pytest.mark.parametrize("place", ["/dev/stdin", "/dev/fd/0", "/proc/self/fd/0"])
def test_a_pipe_that_the_shell_opened_is_read_to_its_end(place: str) -> None:
    program = (
        "from pathlib import Path; from ghostball.model.text_files import read_text; "
        f"print(len(read_text(Path({place!r}))))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], input=b"a" * 300_000, capture_output=True, check=True
    )
    assert done.stdout == b"300000\n"


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="terminals are POSIX")
def test_a_terminal_is_read_until_the_user_ends_the_text() -> None:
    keyboard, terminal = os.openpty()
    typed = Timer(0.1, os.write, (keyboard, b"abc\n\x04"))
    typed.start()
    try:
        # A non-blocking open would return None, because there is no text yet.
        assert read_bytes(Path(os.ttyname(terminal)), 10) == b"abc\n"
    finally:
        typed.join()
        os.close(terminal)
        os.close(keyboard)


def test_text_and_bytes_are_written_whole(tmp_path: Path) -> None:
    write_whole(tmp_path / "text", "größer\n")
    write_whole(tmp_path / "bytes", b"\x00\xff")
    assert (tmp_path / "text").read_bytes() == "größer\n".encode()
    assert (tmp_path / "bytes").read_bytes() == b"\x00\xff"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bytes", "text"]


def test_a_file_that_cannot_be_replaced_is_an_error_without_a_part(tmp_path: Path) -> None:
    (tmp_path / "place").mkdir()
    with pytest.raises(OSError, match="place"):
        write_whole(tmp_path / "place", "text")
    assert [path.name for path in tmp_path.iterdir()] == ["place"]


def test_text_that_utf_8_cannot_hold_touches_no_file(tmp_path: Path) -> None:
    with pytest.raises(UnicodeEncodeError):
        write_whole(tmp_path / "text", "\udc80")
    assert list(tmp_path.iterdir()) == []


def test_a_file_may_have_a_name_of_the_largest_length(tmp_path: Path) -> None:
    path = tmp_path / ("a" * 255)
    write_whole(path, "text")
    assert path.read_text() == "text"
