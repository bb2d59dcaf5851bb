from collections.abc import Callable, Sequence

import pytest
from rich.console import Console

from sunset.cli.train import _lines

Complaint = Callable[[Sequence[str]], str]


@pytest.mark.parametrize(
    ("option", "value", "expected"),
    [
        ("--model", "deep", "'lite', 'reference'"),
        ("--modality", "lidar", "'all', 'rgb', 'depth', 'fusion'"),
        ("--steps", "0", "at least 1"),
    ],
)
def test_a_training_that_there_is_not_is_refused(
    option: str, value: str, expected: str, complaint: Complaint
) -> None:
    sentence = complaint(["train", "--out", "model", option, value])
    assert option in sentence
    assert value in sentence
    assert expected.replace("'", "") in sentence.replace("'", "")


@pytest.mark.parametrize(
    ("option", "value", "expected"),
    [("--steps", "9" * 400, "at most 1000000000 steps"), ("--name", "a\udcff", "UTF-8")],
)
def test_a_training_that_cannot_end_well_is_refused(
    option: str, value: str, expected: str, complaint: Complaint
) -> None:
    assert expected in complaint(["train", "--out", "model", option, value])


def test_lines_tell_how_far_a_training_is() -> None:
    console = Console(width=200, record=True, force_terminal=False)
    times = iter((0.0, 1.0, 75.0, 151.0))
    line = _lines(console, lambda: next(times))
    for step, loss in ((100, ""), (101, "loss rgb 2.000"), (250, "loss rgb 1.500"), (400, "loss rgb 1.000")):
        line("rgb", step, 400, loss)
    assert console.export_text().splitlines() == [
        "rgb: 100 of 400",
        "rgb: 250 of 400, loss rgb 1.500, 2.00/s, 0:01 h left",
        "rgb: 400 of 400, loss rgb 1.000, 1.99/s, 0:00 h left",
    ]
