"""A picture of a shot needs our engine's motion, and says so where the results lack it."""

import pytest

from benchmarks.pictures.shots import our_shot
from ghostball.model import GhostballError
from ghostball.validation.results.store import Results


def test_our_run_is_found_and_its_lack_is_named(small_folder):
    results = Results.open(small_folder)
    shot, run = our_shot(results, "stop")
    assert run is shot.ours
    assert run.motion is not None
    others = Results(
        results.path,
        [one for one in results.cases if one.label != "ghostball"],
        results.environment,
    )
    for lacking, name in ((results, "break-7"), (others, "stop")):
        with pytest.raises(GhostballError, match=f'our engine\'s motion in scene "{name}"'):
            our_shot(lacking, name)
