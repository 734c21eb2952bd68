"""What files and reports call the kinds of events, and which ways to end are no fault."""

from __future__ import annotations

from ghostball.model import EventKind, Status


def test_kinds_have_the_names_of_files_and_reports():
    assert [kind.label for kind in EventKind] == [
        "ball-ball",
        "ball-cushion",
        "slide-to-roll",
        "roll-to-rest",
        "pocketed",
        "ball-cloth",
        "leaves-table",
    ]


def test_a_run_is_complete_where_all_balls_rest_or_its_time_is_over():
    assert [one for one in Status if one.complete] == [Status.REST, Status.T_MAX]
