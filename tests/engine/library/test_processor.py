"""Tests of the processor types for which libraries are compiled."""

import pytest

from ghostball.engine.library import processor
from ghostball.model import GhostballError


@pytest.fixture(autouse=True)
def asked_anew(monkeypatch):
    monkeypatch.setattr(processor, "target", processor.target.__wrapped__)


@pytest.mark.parametrize(
    ("name", "machine", "generic"),
    [
        ("x86_64", "x86_64", "x86-64"),
        ("AMD64", "x86_64", "x86-64"),
        ("aarch64", "arm64", "generic"),
        ("arm64", "arm64", "generic"),
        ("riscv64", "riscv64", "generic"),
    ],
)
def test_a_processor_without_wide_vectors_gets_general_code(monkeypatch, name, machine, generic):
    monkeypatch.setattr(processor.platform, "machine", lambda: name)
    monkeypatch.setattr(processor, "has_wide_vectors", lambda: False)
    assert processor.machine() == machine
    assert processor.target() == generic


def test_a_processor_with_wide_vectors_gets_code_for_them(monkeypatch):
    monkeypatch.setattr(processor.platform, "machine", lambda: "x86_64")
    monkeypatch.setattr(processor.sys, "platform", "linux")
    told = frozenset(("sse2", *processor.NEEDED))
    monkeypatch.setattr(processor, "features", lambda: told)
    assert processor.target() == processor.WIDE
    for one in processor.NEEDED:
        monkeypatch.setattr(processor, "features", lambda one=one: told - {one})
        assert processor.target() == "x86-64"


def test_without_information_from_the_system_there_are_no_features(monkeypatch, tmp_path):
    monkeypatch.setattr(processor, "Path", lambda name: tmp_path / "none")
    monkeypatch.setattr(processor.sys, "platform", "linux")
    assert processor.features() == frozenset()
    assert not processor.has_wide_vectors()


def test_features_are_read_from_what_linux_tells(monkeypatch, tmp_path):
    (tmp_path / "cpuinfo").write_text("processor\t: 0\nflags\t\t: fpu sse2 avx2\nbugs\t: none\n")
    monkeypatch.setattr(processor, "Path", lambda name: tmp_path / "cpuinfo")
    monkeypatch.setattr(processor.sys, "platform", "linux")
    assert processor.features() >= {"fpu", "sse2", "avx2"}
    assert "none" not in processor.features()


def test_another_machine_is_compiled_for_where_it_is_named(monkeypatch):
    monkeypatch.setattr(processor, "features", lambda: processor.NEEDED)
    assert processor.other_triple() is None
    monkeypatch.setenv("GHOSTBALL_BUILD_FOR", "arm64")
    assert processor.other_triple() == "aarch64-unknown-linux-gnu"
    assert (processor.system().partition("-")[2], processor.target()) == ("arm64", "generic")
    monkeypatch.setenv("GHOSTBALL_BUILD_FOR", "vax")
    with pytest.raises(GhostballError, match=r"GHOSTBALL_BUILD_FOR must be one of .*, got 'vax'"):
        processor.other_triple()
