"""Fails where an approximation or a repair stays in the results unseen."""

from ghostball.reports.page.scene_numbers import counted_rows
from ghostball.validation.results.store import Results


def test_what_engines_counted_is_summed_over_the_scenes(module_folder):
    joint = "impacts of one instant, resolved together"
    pulls = "overlapping balls pulled apart"
    where = [(scene, 3) for scene in ("break-7", "head-on", "stop")]
    assert list(counted_rows(Results.open(module_folder))) == [
        ("ghostball", joint, 2, [("break-7", 2)], 0),
        ("paper-discrete", pulls, 9, where, 0),
    ]
