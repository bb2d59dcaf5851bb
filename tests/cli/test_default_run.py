"""What `sunset run` without a scenario tells a newcomer, and where its record is."""

from pathlib import Path

import pytest

from sunset.cli import main
from sunset.data import read_bag, write_bag
from sunset.experiments import last_run
from sunset.recording import read_run

pytestmark = pytest.mark.usefixtures("flight")


@pytest.fixture
def cache(flight: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return an empty cache folder but for the flight and the inferences."""
    folder = tmp_path / "cache"
    folder.mkdir()
    shared = flight.parents[2]
    for part in shared.iterdir():
        if not part.name.startswith((".", "last-run")):
            (folder / part.name).symlink_to(part)
    monkeypatch.setenv("SUNSET_CACHE_DIR", str(folder))
    return folder


def test_the_default_run_tells_of_causes_ripples_and_cures_and_says_what_is_next(
    cache: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run"]) == 0
    told = capsys.readouterr()
    lines = [" ".join(line.split()) for line in told.out.splitlines()]

    behind = lines[lines.index("the faults, which only the oracle is told") + 1 :]
    assert behind[:6] == [
        "camera_driver_issue showed as F1 (the camera sends no images); F2 and F3 by ripple, for lack of input",
        "looks like hardware_disconnect",
        "cured by restart camera, or redeploy camera; done at 1.07 s",
        "image_degradation showed as F4 (the segmentation is unsure of its results)",
        "looks like unneeded_enhancement, image_shift, depth_degradation",
        "cured by activate image_enhancement and set sensor_fusion.topic_camera_input to rgb_enhanced; not done",
    ]
    assert f"The record is in {cache / 'last-run'} until the next run" in told.err
    remarks = [" ".join(line.split()) for line in told.err.splitlines()]
    steps = remarks[remarks.index("Next:") + 1 :]
    assert steps[0] == "sunset view look at this run, frame by frame"
    assert steps[2].startswith("sunset faults list ")
    assert steps[1].startswith("sunset run --manager reactive the same faults")

    assert read_run(last_run()).manager == "baseline"
    assert main(["run", "--manager", "reactive", "--seed", "1", "--duration", "8"]) == 0
    told = capsys.readouterr()
    assert "no symptom is left" in told.out
    assert "set sensor_fusion.topic_camera_input to rgb_enhanced; done at " in told.out
    assert "--manager reactive" not in told.err
    assert read_run(last_run()).manager == "reactive"
    assert [path.name for path in cache.iterdir() if "last-run" in path.name] == ["last-run"]


@pytest.mark.thorough
def test_a_run_for_a_script_and_one_with_a_folder_of_its_own_leave_nothing_else(
    cache: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", "nofault", "--json", "--duration", "2"]) == 0
    assert main(["run", "nofault", "--duration", "2", "--out", str(tmp_path / "mine")]) == 0

    told = capsys.readouterr().err
    assert f"The record is in {tmp_path / 'mine'}.\n" in told
    assert "Next:" not in told
    assert not last_run().exists()
    assert main(["view", "--no-open"]) == 2
    assert f"{cache / 'last-run'} is not a complete record" in capsys.readouterr().err


@pytest.mark.thorough
def test_a_record_that_cannot_be_kept_is_said_to_be_lost_and_the_run_counts(
    flight: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = tmp_path / "short"
    with read_bag(flight) as reader:
        write_bag(bag, map(reader.frame, range(12)), reader.stamps_ns[:12])
    monkeypatch.setenv("SUNSET_CACHE_DIR", "/dev/null/cache")

    assert main(["run", "nofault", "--duration", "1", "--no-cache", "--bag", str(bag), "--loop"]) == 0

    told = capsys.readouterr()
    assert "end of the experiment" in told.out
    assert "The record cannot be kept in /dev/null/cache/last-run: Not a directory; '--out DIR'" in told.err
