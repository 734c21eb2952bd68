"""Findings as SARIF."""

from __future__ import annotations

import json
import re

import pytest
from regressions import regression, worse

from ghostball.reports.ci.sarif import sarif_json
from ghostball.reports.findings import RULES, Place, Places, findings
from ghostball.validation.results.store import Results

NOWHERE = Places(lambda _label, _trace: None, lambda _engine, _scene, _says: None)


@pytest.fixture(scope="module")
def results(results_folder):
    return Results.open(results_folder)


def test_sarif_has_what_the_standard_asks_for(results):
    # SARIF 2.1.0: 3.13 the log, 3.14 the run, 3.18 and 3.19 the tool, 3.27 a result, 3.29 and 3.30
    # where it is. https://docs.oasis-open.org/sarif/sarif/v2.1.0/sarif-v2.1.0.html
    found = findings(results, [regression(worse())], NOWHERE)
    log = json.loads(sarif_json(found, "0.1.0", Place("pyproject.toml", 1)))
    assert set(log) == {"$schema", "version", "runs"}
    assert log["version"] == "2.1.0"
    (run,) = log["runs"]
    driver = run["tool"]["driver"]
    assert (driver["name"], driver["version"]) == ("Ghostball", "0.1.0")
    rules = [rule["id"] for rule in driver["rules"]]
    assert rules == list(RULES)
    assert len(run["results"]) == len(found) > 3
    for result in run["results"]:
        assert rules[result["ruleIndex"]] == result["ruleId"]
        assert result["level"] in ("none", "note", "warning", "error")
        assert result["message"]["text"]
        (location,) = result["locations"]
        physical = location["physicalLocation"]
        assert physical["artifactLocation"]["uri"] == "pyproject.toml"
        assert physical["region"]["startLine"] >= 1
        (fingerprint,) = result["partialFingerprints"].values()
        assert re.fullmatch("[0-9a-f]{64}", fingerprint)
