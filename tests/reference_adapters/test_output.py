"""Output of engines, also from C code, is captured, and control characters are escaped."""

import ctypes
import os
import subprocess
import sys

import pytest

from ghostball.reference_adapters.output import KEPT_BYTES, captured, harmless


def print_everywhere():
    print("from Python")
    ctypes.CDLL(None).puts(b"from C")
    os.write(1, b"raw\n")


def test_what_is_printed_is_kept_and_goes_nowhere_else(capfd):
    print("before")
    with captured() as output:
        print_everywhere()
        print("to standard error", file=sys.stderr)
    print("after")
    assert sorted(output.text.splitlines()) == ["from C", "from Python", "raw"]
    seen = capfd.readouterr()
    assert (seen.out, seen.err) == ("before\nafter\n", "to standard error\n")


def test_standard_error_is_kept_where_that_is_asked_for(capfd):
    with captured(errors=True) as output:
        print("one", file=sys.stderr)
        os.write(2, b"two\n")
    assert sorted(output.text.splitlines()) == ["one", "two"]
    assert capfd.readouterr() == ("", "")


def test_it_is_kept_also_where_the_block_raises(capfd):
    kept = []

    def fail():
        with captured() as output:
            kept.append(output)
            print("last words")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert kept[0].text == "last words"
    print("heard again")
    assert capfd.readouterr().out == "heard again\n"


def test_of_much_the_start_and_the_end_are_kept():
    with captured() as output:
        print("first")
        print("x" * 10 * KEPT_BYTES)
        print("last")
    assert output.text.startswith("first\n")
    assert output.text.endswith("last")
    assert "bytes omitted]" in output.text
    assert len(output.text) < 2 * KEPT_BYTES + 100


def test_bytes_that_are_no_text_are_shown():
    with captured() as output:
        os.write(1, b"\xff\xfe\n")
    assert output.text == "\\xff\\xfe"


def test_a_process_that_is_diverted_prints_into_a_file(tmp_path):
    code = (
        "import os, sys; from ghostball.reference_adapters.output import divert, flush;"
        "divert(sys.argv[1]); print('out'); print('err', file=sys.stderr); os.write(1, b'raw');"
        "flush()"
    )
    path = tmp_path / "output"
    path.write_text("")
    with path.open() as file:
        done = subprocess.run([sys.executable, "-c", code, path], capture_output=True, check=True)
        assert (done.stdout, done.stderr) == (b"", b"")
        assert file.read() == "out\nerr\nraw"


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("\x1b[31mred\x1b[0m", "\\x1b[31mred\\x1b[0m"),
        ("\x1b]0;title\x07", "\\x1b]0;title\\x07"),
        ("\u202eneerg\u202c \u2066x\u2069", "\\u202eneerg\\u202c \\u2066x\\u2069"),
        ("a\u200bb\u2028c\ufeff\U000e0041\ud800", "a\\u200bb\\u2028c\\ufeff\\U000e0041\\ud800"),
        ("כדור 8", "כדור 8"),
        ("\x9b31m", "\\x9b31m"),  # C1: the same as ESC [ in one character
        ("over\rwritten\b", "over\\rwritten\\x08"),
        ("\x7f\x00", "\\x7f\\x00"),
        ("umlauts äöü, a tab\tand\na line", "umlauts äöü, a tab\tand\na line"),
    ],
)
def test_control_characters_are_shown(text, shown):
    assert harmless(text) == shown
    assert harmless(shown) == shown
