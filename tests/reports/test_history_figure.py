"""Fails where a panel shows other versions than were measured, or mixes machines."""

import pytest

from ghostball.engine import GhostballError
from ghostball.reports import style
from ghostball.reports.history_figure import MOST_PANELS, draw_history, revision_text
from ghostball.validation.bench._observed import Observed
from ghostball.validation.bench.history import History, Version


def version(machine, revision, day, values, *, dirty=False):
    date = f"2026-01-{day:02}T00:00:00+00:00"
    return Version(machine, "f" * 40, revision * 40, dirty, date, values)


def kernel(value, **more):
    return {"break/kernel": Observed(value, "s", 0.5 * value, 2.0 * value, **more)}


HISTORY = History(
    "targets",
    (
        version("box", "a", 1, kernel(4e-5)),
        version("other", "b", 2, kernel(6e-5)),
        version("box", "c", 3, kernel(1e-5, target=3e-5, target_kind="at_most"), dirty=True),
        version("box", "d", 4, {"gas/bytes": Observed(347.0, "B")}),
    ),
)


def test_each_quantity_has_a_panel_with_a_line_for_each_machine():
    with style.drawing():
        figure = draw_history(HISTORY)
        panels = {axes.get_title(loc="left"): axes for axes in figure.axes if axes.axison}
        assert set(panels) == {"break/kernel", "gas/bytes"}
        axes = panels["break/kernel"]
        box, other = axes.containers
        ticks = [label.get_text() for label in axes.get_xticklabels()]
    assert (box.get_label(), other.get_label()) == ("box", "other")
    assert list(box[0].get_xdata()) == [0, 2]
    assert list(box[0].get_ydata()) == [4e-5, 1e-5]
    assert list(other[0].get_xdata()) == [1]
    assert box[2][0].get_segments()[0][:, 1].tolist() == pytest.approx([2e-5, 8e-5])
    assert ticks == ["aaaaaaa\n2026-01-01", "bbbbbbb\n2026-01-02", "ccccccc+\n2026-01-03"]
    assert [text.get_text() for text in axes.texts] == ["target ≤ 30 µs"]


def test_what_is_counted_has_no_spread():
    with style.drawing():
        axes = next(a for a in draw_history(HISTORY).axes if a.get_title(loc="left") == "gas/bytes")
        (bar,) = [one for one in axes.containers if len(one[0].get_xdata())]
        (low, high) = bar[2][0].get_segments()[0][:, 1]
    assert low == high == 347.0


def test_wide_ranges_are_logarithmic():
    wide = History(
        "targets", tuple(version("box", c, 1, kernel(v)) for c, v in (("a", 1e-5), ("b", 1e-2)))
    )
    with style.drawing():
        assert draw_history(wide).axes[0].get_yscale() == "log"
        assert draw_history(HISTORY).axes[0].get_yscale() == "linear"


def test_too_many_quantities_are_refused_with_what_to_do():
    values = {f"q{k}": Observed(1.0, "1") for k in range(MOST_PANELS + 1)}
    with pytest.raises(GhostballError, match="`--quantity`, such as 'q0'"):
        draw_history(History("targets", (version("box", "a", 1, values),)))


def test_a_revision_that_is_not_known_says_so():
    assert revision_text(version("box", "", 1, {})) == "unknown"
