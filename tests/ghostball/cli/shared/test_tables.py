"""Tables cut no name short, set numbers to the right, and take no text for markup."""

import pytest
from rich.console import Console

from ghostball.cli.shared.tables import facts_table, table_of


def printed(table, width=80):
    console = Console(width=width)
    with console.capture() as capture:
        console.print(table)
    return capture.get()


def test_numbers_are_set_to_the_right_and_titles_above():
    table = table_of(("scene", "balls"), [("stop", "1"), ("break", "16")], right=("balls",))
    lines = [line.rstrip() for line in printed(table).splitlines() if line.strip()]
    assert len({len(line) for line in lines if "─" not in line}) == 1
    assert lines[-1].endswith("16")


@pytest.mark.parametrize(("whole", "kept"), [(None, "first"), (("second",), "second")])
def test_the_first_column_is_whole_unless_others_are_named(whole, kept):
    cells = {"first": "a long name of a scene", "second": "a long name of an engine"}
    table = table_of(tuple(cells), [tuple(cells.values())], whole=whole)
    assert [name for name, text in cells.items() if text in printed(table, 36)] == [kept]


def test_facts_are_no_markup():
    assert "[red]1[/]" in printed(facts_table({"work": "[red]1[/]"}))
