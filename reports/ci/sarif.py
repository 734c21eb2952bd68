"""Findings as SARIF 2.1.0, which the Security tab of a forge and editors read.

OASIS, "Static Analysis Results Interchange Format (SARIF) Version 2.1.0", 2020.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from hashlib import sha256
from typing import Any

from ghostball.reports.findings import RULES, Finding, Place

SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"


def sarif_json(found: Sequence[Finding], version: str, beside: Place) -> str:
    """Return findings as one JSON document.

    `version`: of ghostball.
    `beside`: where what has no place is shown: GitHub takes no result without one.
    """
    names = list(RULES)
    driver = {
        "name": "Ghostball",
        "version": version,
        "rules": [{"id": name, "shortDescription": {"text": text}} for name, text in RULES.items()],
    }
    run = {
        "tool": {"driver": driver},
        "columnKind": "unicodeCodePoints",
        "results": [_result(one, names.index(one.rule), beside) for one in found],
    }
    return json.dumps({"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}, indent=1) + "\n"


def _result(one: Finding, index: int, beside: Place) -> dict[str, Any]:
    place = one.place or beside
    artifact = {"uri": place.file, "uriBaseId": "%SRCROOT%"}
    return {
        "ruleId": one.rule,
        "ruleIndex": index,
        "level": one.level,
        "message": {"text": f"{one.title}\n{one.message}"},
        "locations": [
            {
                "physicalLocation": {
                    "artifactLocation": artifact,
                    "region": {"startLine": place.line},
                }
            }
        ],
        # The same finding in the next run, whatever its numbers are then.
        "partialFingerprints": {
            "ghostball/v1": sha256(f"{one.rule} {one.title}".encode()).hexdigest()
        },
    }
