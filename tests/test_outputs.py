"""`python -m docs.outputs`: blocks are run, outputs written once, and stale ones refused."""

import pytest

pytestmark = pytest.mark.checkout

PAGE = """Text.

<!-- run python
print("a | b")
-->
<!-- end -->

<!-- run shell as=console exit=3
secret=1  # hide
echo "took 5 ms" && exit 3
-->
<!-- end -->
"""


@pytest.fixture
def page(tmp_path):
    path = tmp_path / "page.md"
    path.write_text(PAGE, "utf-8")
    return path


def test_outputs_stand_beneath_their_blocks_and_stay_where_durations_alone_differ(page):
    from docs.outputs import write_outputs

    write_outputs([page], check=False)
    text = page.read_text("utf-8")
    assert "-->\n\na | b\n\n<!-- end -->" in text
    assert '```console\n$ echo "took 5 ms" && exit 3\ntook 5 ms\n```' in text
    later = text.replace("\ntook 5 ms", "\ntook 7.1 ms")
    page.write_text(later, "utf-8")
    write_outputs([page], check=True)
    assert page.read_text("utf-8") == later


def test_other_outputs_are_refused_by_the_page_that_has_them(page):
    from docs.outputs import OutputError, write_outputs

    with pytest.raises(OutputError, match=r"page\.md.*make docs-outputs"):
        write_outputs([page], check=True)
    assert page.read_text("utf-8") == PAGE
    page.write_text(PAGE.replace("exit=3", "exit=0"), "utf-8")
    with pytest.raises(OutputError, match="ended with 3, expected 0"):
        write_outputs([page], check=False)
