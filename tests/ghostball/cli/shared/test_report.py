"""Output from stored results: the report, and formats for other programs."""

import json
from functools import partial
from xml.etree import ElementTree

import pytest
from regressions import regression, worse
from table_agreements import keep_likenesses, likeness
from written_results import LABELS, write_results

from ghostball.cli.shared import report
from ghostball.reports import FailedPart, IncompleteReportError
from ghostball.validation.baselines import save_regressions
from ghostball.validation.exit_status import ExitStatus

# Parts of a report that can't be made are a bug: the last message, and the exit status of a bug

FAILED = [FailedPart(f"section {k}", "KeyError: 1", "Traceback: here") for k in range(2)]


@pytest.mark.parametrize("failed", [[], FAILED])
def test_failed_parts_are_reported_once_with_a_traceback(tmp_path, monkeypatch, capsys, failed):
    page = tmp_path / "report.html"

    def made(folder, **how):
        assert (folder, how["jobs"], how["figures"]) == (tmp_path, 2, "none")
        if failed:
            raise IncompleteReportError(page, failed)
        return page

    monkeypatch.setattr(report, "write_report", made)
    written = report.write(tmp_path, jobs=2, figures="none")
    assert written.page == page
    assert written.status() is (ExitStatus.HARNESS_FAILED if failed else ExitStatus.PASSED)
    said = capsys.readouterr().err
    assert said.count("Traceback: here") == bool(failed)
    assert ("2 parts of it could not be written: section 0" in said) is bool(failed)


# Stored results are printed for other programs, without any other output


@pytest.fixture
def small_folder(tmp_path):
    return write_results(tmp_path / "small", ["stop"], LABELS[:3])


@pytest.fixture
def invoke(cli):
    return partial(cli, "report")


def test_the_command_prints_and_writes_no_report(small_folder, invoke):
    save_regressions([regression(worse())], small_folder)
    assert "### What changed" in invoke(small_folder, "--format", "markdown").stdout
    done = invoke(small_folder, "--format", "text")
    assert done.exit_code == 0
    assert done.stdout.startswith("break-7: error: ghostball: worse, ")
    assert not (small_folder / "report.html").exists()


def test_one_document_has_checks_and_changes(small_folder, invoke):
    save_regressions([regression(worse())], small_folder)
    document = ElementTree.fromstring(invoke(small_folder, "--format", "junit").stdout.encode())
    names = {one.get("name") for one in document.iter("testcase")}
    assert {"ghostball: baseline", "ghostball: rest_error_max"} <= names
    plain = json.loads(invoke(small_folder, "--format", "json").stdout)
    assert {"state", "cases", "checks", "metrics"} < set(plain)
    assert [one["outcome"] for one in plain["regressions"]] == ["failed"]


def test_the_json_has_the_comparisons_with_real_tables(small_folder, invoke):
    assert json.loads(invoke(small_folder, "--format", "json").stdout)["real_tables"] == []
    keep_likenesses(small_folder, [likeness("ghostball", rebound=-3.0, rolling="it rolls none")])
    (one,) = json.loads(invoke(small_folder, "--format", "json").stdout)["real_tables"]
    assert (one["label"], one["typical"]) == ("ghostball", pytest.approx(3.0))
    rebound, rolling = one["families"]
    assert (rebound["name"], rebound["grades"], rebound["lacks"]) == ("rebound", True, "")
    assert (rebound["typical"], rebound["most"]) == (pytest.approx(3.0), pytest.approx(3.0))
    assert set(rebound["figures"][0]) == {"at", "value", "error", "played", "what"}
    assert (rolling["typical"], rolling["most"]) == (None, None)
    assert (rebound["is_within_known"], rolling["is_within_known"]) == (False, None)
    assert rolling["lacks"] == "it rolls none"
