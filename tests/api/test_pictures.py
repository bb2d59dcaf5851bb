"""Pictures of single faults: what they show, and which are refused."""

import re
from pathlib import Path

import pytest

import sunset
from sunset.cli import main
from sunset.errors import InvalidInputError

pytestmark = pytest.mark.usefixtures("flight")


def texts(file: Path) -> list[str]:
    """Return the texts of a drawing, which stand in its comments."""
    return re.findall(r"<!-- (.*?) -->", file.read_text(encoding="utf-8"))


def numbers(text: str) -> list[float]:
    return [float(number) for number in re.findall(r"\d+\.\d+", text)]


def test_a_degradation_is_drawn_on_a_frame_with_what_it_costs_and_what_its_cure_brings_back(
    tmp_path: Path,
) -> None:
    file = tmp_path / "figures" / "shift.svg"
    assert main(["faults", "show", "image_shift", "--figure", str(file), "--frame", "7"]) == 0

    told = texts(file)
    assert {"without a fault", "image_shift", "cured"} <= set(told)
    healthy, faulty, cured = (numbers(text)[0] for text in told if text.startswith("IoU "))
    assert cured == healthy > faulty  # a recalibration makes the images what they were
    well, unsure, well_again = (text for text in told if text.startswith("entropy "))
    assert well == well_again
    assert (
        numbers(unsure)[0] > numbers(unsure)[1] == numbers(well)[1] > numbers(well)[0]
    )  # that is the threshold
    assert unsure.endswith(": symptom")

    again = tmp_path / "again.svg"
    assert sunset.fault_picture("image_shift", again, frame=7) == again
    assert again.read_bytes() == file.read_bytes()


@pytest.mark.thorough
def test_a_cure_that_leaves_the_depth_out_is_shown_by_what_colours_alone_give(tmp_path: Path) -> None:
    sunset.fault_picture("depth_degradation", tmp_path / "depth.svg", frame=7)

    told = texts(tmp_path / "depth.svg")
    healthy, faulty, cured = (numbers(text)[0] for text in told if text.startswith("IoU "))
    assert faulty < cured < healthy


def test_an_outage_is_drawn_over_time_with_its_ripples_and_repairs(tmp_path: Path) -> None:
    sunset.fault_picture("hardware_disconnect", tmp_path / "outage.svg", duration=7)

    told = texts(tmp_path / "outage.svg")
    assert {"rgb_camera", "sensors_fused", "segmentation", "fault"} <= set(told)
    assert {" restart camera", " redeploy camera"} <= set(told)
    silences = [numbers(text)[0] for text in told if re.fullmatch(r"\d\.\d s", text)]
    assert len(silences) == 3
    assert all(5 < silence < 7 for silence in silences)  # until a redeployed camera is active, 4 s later


@pytest.mark.parametrize(
    ("fault", "file", "frame", "said"),
    [
        ("gpu_failure", "a.png", 3, "stops messages: it is drawn over time; leave out --frame"),
        ("image_shift", "a.png", 400, "The frame must be from 0 to 399 in "),
        ("image_shift", "a.doc", None, "must end in .pdf, .png, .svg"),
    ],
)
def test_what_cannot_be_drawn_is_said(
    fault: str, file: str, frame: int | None, said: str, tmp_path: Path
) -> None:
    with pytest.raises(InvalidInputError, match=re.escape(said)):
        sunset.fault_picture(fault, tmp_path / file, frame=frame)
    assert list(tmp_path.iterdir()) == []
