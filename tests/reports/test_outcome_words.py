"""A verdict never says "Passed" over cases that are no true shot: limits ask less of them."""

from types import SimpleNamespace

from ghostball.reports.accuracy import wrong_text


def cases(**counts):
    return [
        SimpleNamespace(accuracy=SimpleNamespace(kind=kind.replace("_", " ")))
        for kind, count in counts.items()
        for _ in range(count)
    ] + [SimpleNamespace(accuracy=None)]


def test_cases_that_are_no_true_shot_are_counted():
    assert wrong_text(cases(exact=3, centimetres=1)) == ""
    assert wrong_text(cases(another_shot=5, broken=2, exact=1)) == "2 broken, 5 another shot"
