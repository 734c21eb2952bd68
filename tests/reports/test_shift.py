"""The picture of rest errors before and now."""

from __future__ import annotations

from regressions import regression, unchanged, worse

from ghostball.reports.shift import SHOTS, WIDTH, drawn, error_text, growth, shifted


def moved(scene: str, before: float | None, now: float | None):
    return worse(scene, base_error=before, head_error=now)


def test_what_got_worse_by_most_comes_first_and_what_did_not_move_is_left_out() -> None:
    better, same, lost = moved("better", 1e-3, 1e-4), moved("same", 1e-3, 1e-3), moved("x", 1, None)
    found = shifted(regression(better, same, worse(), lost, unchanged()))
    assert [one.scene for one in found] == ["break-7", "better"]
    assert [error_text(one) for one in (better, same, lost)] == ["1 mm -> 100 µm", "1 mm", ""]
    assert growth(worse()) > 0.0 > growth(better)
    assert growth(lost) == growth(same) == 0.0


def test_a_place_on_the_line_is_a_power_of_ten() -> None:
    shown = [moved("a", 1e-3, 1e-1), moved("long-name", 1e-2, 1e-2), moved("b", 1e-1, 1e-3)]
    first, second, third, axis, *_ = drawn(shown).splitlines()
    start = len("long-name") + 2
    assert first[start] == "○"
    assert first[start + WIDTH - 1] == "●"
    assert third[start] == "●"
    assert second[start:].index("◉") == round((WIDTH - 1) / 2)
    assert axis.split() == ["1", "mm", "100", "mm"]
    assert len(axis) == start + WIDTH


def test_nothing_and_too_much_are_no_trouble() -> None:
    assert drawn([]) == ""
    many = [moved(f"s{k}", 0.0, 10.0**-k) for k in range(SHOTS + 3)]
    assert drawn(many).splitlines()[-1].endswith("; 3 more moved less")
    assert len(drawn([moved("none", 0.0, 0.0)]).splitlines()) == 4
