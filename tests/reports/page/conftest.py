"""A whole page."""

import pytest
from page_texts import page_of


@pytest.fixture(scope="module")
def html(module_folder):
    """Three scenes on seven engines: some pass, some fail, one crashed, one can't represent."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("ghostball.reports.report.draw_sheet", lambda _: None)
        return page_of(module_folder)
