"""Fails where a failure isn't explained, or can't be seen again by its command."""

import re

from page_texts import section


def test_every_failure_is_explained_with_its_command_and_what_it_must_give(html):
    text = section(html, "failures")
    assert text.count('<details class="failure"') == 7
    assert "<dt>Expected<dd>at most 5 mm" in text
    assert "<dt>Found<dd>30 mm (0.03 m)" in text
    assert "ghostball explain stop --engine paper-discrete" in text
    assert "ghostball run head-on --engine newcomer:dt=1e-3" in text
    assert re.search(r'<code>hash</code> [^<]* <code class="hash">[0-9a-f]{64}</code>', text)
    assert "<code>cue</code> at (1.47, 0.8) m" in text
