"""What an engine adds to an installation: fails where a need, or a file, is left out or foreign."""

from importlib.metadata import distribution

from ghostball.validation.board.board import run_board
from ghostball.validation.board.column import COLUMNS
from ghostball.validation.board.installed import installed_size


def size_of(name):
    return sum(file.locate().stat().st_size for file in distribution(name).files)


def test_an_engine_counts_with_what_it_needs():
    needs = [size_of(name) for name in ("pymunk", "cffi", "pycparser")]
    assert installed_size("pymunk:mode=landed") == sum(needs)
    assert installed_size("ghostball") == size_of("numba") + size_of("llvmlite")


def test_what_is_a_part_of_ghostball_or_of_the_user_has_no_size(tmp_path):
    assert installed_size("paper-discrete") is None
    assert installed_size("pooltool") is None
    assert installed_size("my_package:MyEngine") is None
    board, _ = run_board(["paper-discrete"], tmp_path, columns=[COLUMNS["size"]])
    assert [cell.kind for cell in board.cells] == ["none"]
