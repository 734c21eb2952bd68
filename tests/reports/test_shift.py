"""The picture of how far shots ended off the truth, before and now."""

from __future__ import annotations

from regressions import identical, quantity, regression, worse

from ghostball.reports.shift import SHOTS, WIDTH, Shift, drawn, shift_of, shifts_of


def test_what_got_worse_by_most_comes_first_and_what_did_not_move_is_left_out() -> None:
    better = worse("better", metrics=(quantity("rest_error_max", base=1e-3, head=1e-4),))
    same = identical("same", metrics=(quantity("rest_error_max", base=1e-3, head=1e-3),))
    lost = worse("lost", metrics=(quantity("rest_error_max", base=1e-3, head=None),))
    found = shifts_of(regression(better, same, worse(), lost, identical()))
    assert [one.scene for one in found] == ["break-7", "better"]
    assert found[1] == Shift("better", 1e-3, 1e-4) == shift_of(better)
    assert found[1].words == "1 mm -> 100 µm"
    assert shift_of(same) is None
    assert Shift.of(same).words == "1 mm"
    assert Shift.of(lost) is None


def test_a_place_on_the_line_is_a_power_of_ten() -> None:
    shifts = [Shift("a", 1e-3, 1e-1), Shift("long-name", 1e-2, 1e-2), Shift("b", 1e-1, 1e-3)]
    first, second, third, axis, *_ = drawn(shifts).splitlines()
    start = len("long-name") + 2
    assert first[start] == "○"
    assert first[start + WIDTH - 1] == "●"
    assert third[start] == "●"
    assert second[start:].index("◉") == round((WIDTH - 1) / 2)
    assert axis.split() == ["1", "mm", "100", "mm"]
    assert len(axis) == start + WIDTH


def test_nothing_and_too_much_are_no_trouble() -> None:
    assert drawn([]) == ""
    many = [Shift(f"s{k}", 0.0, 10.0**-k) for k in range(SHOTS + 3)]
    assert drawn(many).splitlines()[-1].endswith("; 3 more moved less")
    assert len(drawn([Shift("none", 0.0, 0.0)]).splitlines()) == 4
