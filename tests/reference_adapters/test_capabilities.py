"""Files of capabilities: values, and messages for mistakes."""

from __future__ import annotations

from pathlib import Path

import pytest

from ghostball.model.features import EXACT, Capability, Feature
from ghostball.reference_adapters import EngineError
from ghostball.reference_adapters.capabilities import FILE, capabilities_beside

ALL = "\n".join(f'{feature.name} = "exact"' for feature in reversed(Feature))
"""Every feature, in another order."""


def read(folder: Path, text: str):
    (folder / FILE).write_text(text)
    return capabilities_beside(str(folder / "engine.py"), "mine")


def test_another_configuration_has_what_differs_from_the_first_and_features_are_in_order(tmp_path):
    found = read(
        tmp_path,
        f"""[mine.tuned]
        {ALL.replace('SLIDING = "exact"', 'SLIDING = "exact: by hand: well"')}
        [mine.naive]
        FLIGHT = "none: it works in a plane"
        [mine.own-cloth]
        ROLLING = "approximate: in steps"
        """,
    )
    assert list(found) == ["tuned", "naive", "own-cloth"]
    assert all(list(one) == list(Feature) for one in found.values())
    assert found["tuned"][Feature.SLIDING] == Capability("exact", "by hand: well")
    assert found["naive"][Feature.FLIGHT] == Capability("none", "it works in a plane")
    assert found["own-cloth"] == {
        **found["tuned"],
        Feature.ROLLING: Capability("approximate", "in steps"),
    }
    assert found["own-cloth"][Feature.FLIGHT] == EXACT


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("[mine.tuned", ["can't be read: Expected"]),
        ("[other.tuned]", ["must have a table `[mine.CONFIGURATION]`", "got other"]),
        ("", ["must have a table `[mine.CONFIGURATION]`", "got an empty file"]),
        ("[mine]\ntuned = 1", ["[mine.tuned]", "must be a table of features, got 1"]),
        ("[mine.tuned]\nsliding = 'exact'", ["[mine.tuned]", "`sliding`", "mean `SLIDING`?"]),
        ("[mine.tuned]\nx = 'exact'", ["`x` is not a member of `Feature`", "There are ROLLING,"]),
        ("[mine.tuned]\nSLIDING = 'nearly: so'", ["`SLIDING` must be", "got 'nearly: so'"]),
        ("[mine.tuned]\nSLIDING = true", ["`SLIDING` must be", "got True"]),
        ("[mine.tuned]\nSLIDING = 'none: '", ["must say why not after", "got 'none: '"]),
        ("[mine.tuned]\nSLIDING = 'approximate'", ["must say how after", "got 'approximate'"]),
        ("[mine.tuned]\nSLIDING = 'exact'", ["every feature, but lacks ROLLING, FRICTIONLESS"]),
    ],
)
def test_a_mistake_names_file_configuration_rule_and_value(tmp_path, text, parts):
    with pytest.raises(EngineError) as caught:
        read(tmp_path, text)
    for part in (str(tmp_path / FILE), *parts):
        assert part in str(caught.value)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(EngineError, match=f"{FILE} can't be read: "):
        capabilities_beside(str(tmp_path / "engine.py"), "mine")
