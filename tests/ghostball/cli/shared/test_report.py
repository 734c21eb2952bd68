"""Parts of a report that can't be made are a bug: said after all else, with the status of one."""

import pytest

from ghostball.cli.shared import report
from ghostball.reports import FailedPart, IncompleteReportError
from ghostball.validation.exit_status import ExitStatus

FAILED = [FailedPart(f"section {k}", "KeyError: 1", "Traceback: here") for k in range(2)]


@pytest.mark.parametrize("failed", [[], FAILED])
def test_what_could_not_be_made_is_said_with_its_traceback_once(
    tmp_path, monkeypatch, capsys, failed
):
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
    assert ("2 parts of it could not be made: section 0" in said) is bool(failed)
