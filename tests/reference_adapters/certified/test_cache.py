"""Certificates on the disk: names depend on all inputs; unreadable certificates are recomputed."""

from __future__ import annotations

import logging
import math
import os

import numpy as np
import pytest
from shots import POOL_TABLE, ball, scene_of

from ghostball.model import Scene
from ghostball.reference_adapters.certified import CertifiedSettings, api, cache, certify
from ghostball.reference_adapters.certified.problem import problem_of
from ghostball.reference_adapters.registry import make_engine


def shot(x: float = 0.5, **fields) -> Scene:
    return scene_of(ball((x, 0.6), (1.0, 0.2)), ball((1.0, 0.7)), table=POOL_TABLE, **fields)


@pytest.fixture
def proofs(monkeypatch):
    """Count the computed certificates."""
    computed = []
    prove = api.prove

    def counting(*args, **kwargs):
        computed.append(args)
        return prove(*args, **kwargs)

    monkeypatch.setattr(api, "prove", counting)
    return computed


def test_the_same_scene_is_computed_once(proofs, kept_here):
    first = certify(shot())
    again = certify(shot())
    assert len(proofs) == 1
    assert again.to_json() == first.to_json()
    assert len(list(kept_here.glob("certificate-*.json"))) == 1


@pytest.mark.parametrize(
    "other",
    [
        shot(math.nextafter(0.5, 1.0)),
        shot(t_max=1.0),
        shot(ball_restitution=0.99),
        shot(rolling_friction=0.0, t_max=1.0),
    ],
)
def test_another_scene_is_computed(proofs, other):
    certify(shot())
    certify(other)
    assert len(proofs) == 2


def test_other_settings_and_motion_are_computed(proofs):
    certify(shot())
    certify(shot(), CertifiedSettings(width=1e-20))
    certify(shot(), motion=True)
    assert len(proofs) == 3


def test_other_code_is_computed(proofs, monkeypatch):
    certify(shot())
    monkeypatch.setattr(cache, "code_hash", lambda: "other")
    certify(shot())
    assert len(proofs) == 2


def test_the_code_hash_sees_every_source(monkeypatch, tmp_path):
    before = cache.code_hash.__wrapped__()
    assert before == cache.code_hash()
    copy = tmp_path / "copy"
    copy.mkdir()
    for path in cache.Path(cache.__file__).parent.glob("*.py"):
        (copy / path.name).write_bytes(path.read_bytes())
    monkeypatch.setattr(cache, "__file__", str(copy / "cache.py"))
    assert cache.code_hash.__wrapped__() == before
    (copy / "laws.py").write_text((copy / "laws.py").read_text() + "\n# changed\n")
    assert cache.code_hash.__wrapped__() != before


@pytest.mark.parametrize("content", [b"", b"{", b'{"schema": 1}', b"\xff\xfe", b"null"])
def test_a_file_that_cannot_be_read_is_computed_anew(proofs, kept_here, caplog, content):
    first = certify(shot())
    (path,) = kept_here.glob("certificate-*.json")
    whole = path.read_bytes()
    path.write_bytes(content)
    with caplog.at_level(logging.WARNING):
        again = certify(shot())
    assert "recomputing it" in caplog.text
    assert (len(proofs), again.events) == (2, first.events)
    assert len(path.read_bytes()) == pytest.approx(len(whole), abs=30)  # the computing time differs
    certify(shot())
    assert len(proofs) == 2


IN_AIR = {
    "rolls": scene_of(ball((0.0, 0.0), (1.0, 0.0)), air_drag=0.1, table=None),
}


@pytest.mark.parametrize("name", IN_AIR)
def test_a_motion_in_air_reads_back_to_the_same_bits(proofs, name):
    """Segments must be read with the columns with which they were written."""
    motions = [make_engine("certified").simulate(IN_AIR[name], record="trajectory") for _ in "12"]
    assert len(proofs) == 1
    times = np.linspace(0.0, motions[0].rest_time, 101)
    for first, again in zip(*(motion.sample(times) for motion in motions), strict=True):
        assert first.tobytes() == again.tobytes()
    assert np.ptp(motions[1].sample(times).positions[:, 0, 0]) > 0.5
    first, again = (motion.trajectory for motion in motions)
    assert again.orientation(times).tobytes() == first.orientation(times).tobytes()


@pytest.mark.parametrize(
    "damage",
    [
        lambda text: text[: len(text) // 2],
        lambda text: text.replace("86", "43", 1),
        lambda text: text.replace("0.1", "0.2", 1),
    ],
    ids=["cut short", "reshaped", "another number"],
)
def test_a_damaged_entry_is_refused_in_one_line_and_replaced(proofs, kept_here, caplog, damage):
    first = certify(IN_AIR["rolls"], motion=True)
    (path,) = kept_here.glob("certificate-*.json")
    text = path.read_text("utf-8")
    assert damage(text) != text
    path.write_text(damage(text), "utf-8")
    again = certify(IN_AIR["rolls"], motion=True)
    (record,) = caplog.records
    assert "damaged" in record.getMessage()
    assert "\n" not in record.getMessage()
    assert len(proofs) == 2
    assert again.segments[0].tobytes() == first.segments[0].tobytes()
    certify(IN_AIR["rolls"], motion=True)
    assert (len(proofs), len(caplog.records)) == (2, 1)


def test_an_entry_of_another_shot_is_refused(kept_here, caplog):
    certify(shot())
    (path,) = kept_here.glob("certificate-*.json")
    path.rename(cache.path_of("other"))
    assert cache.read("other") is None
    (record,) = caplog.records
    assert "\n" not in record.getMessage()
    assert not list(kept_here.glob("certificate-*.json"))


def test_a_folder_that_cannot_be_written_costs_only_time(proofs, monkeypatch, caplog, tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("no folder")
    monkeypatch.setattr(cache, "directory", lambda: blocked / "below")
    with caplog.at_level(logging.WARNING):
        assert certify(shot()).proved
        assert certify(shot()).proved
    assert "GHOSTBALL_CACHE_DIR" in caplog.text
    assert len(proofs) == 2


def test_the_certificates_longest_unused_go_first(monkeypatch, kept_here):
    monkeypatch.setattr(cache, "MAX_CERTIFICATES", 2)
    for age, x in enumerate((0.5, 0.51)):
        certify(shot(x))
        for path in kept_here.iterdir():
            os.utime(path, (1000 + age, 1000 + age))
    certify(shot())  # used again, so this is the most recently used one
    certify(shot(0.52))
    assert len(list(kept_here.iterdir())) == 2
    keys = {path.name for path in kept_here.iterdir()}
    unused = cache.key_of(problem_of(shot(0.51)), ("b0", "b1"), CertifiedSettings(), False)
    assert f"certificate-{unused}.json" not in keys
