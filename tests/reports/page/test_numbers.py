"""Fails where a section of numbers doesn't say what is missing in it."""

from page_texts import folded


def test_what_is_missing_says_so_and_how_to_get_it(html):
    for name, words in {
        "closed-forms": "is what rounding the scene’s numbers once would cause",
        "cost": "one sample of its run time each",
        "horizons": "can be predicted to their end",
        "energy": "No motion of an engine that records it exactly is stored",
        "hashes": "No comparison was made",
        "timing": "One sample each",
    }.items():
        assert words in folded(html, name), name
