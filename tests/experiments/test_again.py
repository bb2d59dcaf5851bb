from pathlib import Path

import msgspec
import pytest
from msgspec import UNSET
from msgspec.structs import replace

from sunset.data import read_bag, write_bag
from sunset.errors import RecordError
from sunset.experiments import RunSpec, Settings, Timing, play_back, run, run_again
from sunset.recording import RunRecord, read_images, read_run
from sunset.scenarios import load_scenario

TIMING = Timing(duration_s=2.0, warm_up_s=0.5)

pytestmark = pytest.mark.usefixtures("flight")


@pytest.fixture(scope="module")
def stored(flight: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a run, with a managing system of its own under another name."""
    assert flight.exists()
    folder = tmp_path_factory.mktemp("again")
    mine = folder / "mine.py"
    mine.write_text(
        "from sunset.managing import ManagingSystem\n\n"
        "class Mine(ManagingSystem):\n"
        "    def adapt(self, symptoms):\n"
        "        self.get_logger().info('here', once=True)\n"
    )
    spec = RunSpec(
        scenario=load_scenario("image_shift=7+gpu_failure"),
        manager=f"own={mine}:Mine",
        seed=5,
        settings=Settings(timing=TIMING),
    )
    run(spec, folder / "run")
    return folder / "run"


def rewritten(stored: Path, folder: Path, **changed: object) -> Path:
    """Return a copy of a record whose `run.json` says something else."""
    folder.mkdir()
    for file in stored.iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    record: RunRecord = replace(read_run(stored), **changed)
    (folder / "run.json").write_bytes(msgspec.json.encode(record))
    return folder


def test_a_run_comes_out_the_same_and_shows_what_it_did_not_keep(stored: Path, tmp_path: Path) -> None:
    again = run_again(stored, tmp_path / "again", trust=True, images=True)

    assert again.digest == read_run(stored).digest
    for name in ("messages.mcap", "metadata.yaml", "run.json"):
        assert (again.folder / name).read_bytes() == (stored / name).read_bytes()
    topics = {image.topic for image in read_images(again.folder)}
    assert {"/rgb_raw", "/gt_segmentation", "/managed_subsystem/segmentation"} <= topics


def test_code_that_a_record_names_runs_only_where_it_is_trusted(stored: Path, tmp_path: Path) -> None:
    with pytest.raises(RecordError, match=r"mine\.py:Mine', which is code that the record names: read it"):
        run_again(stored, tmp_path / "again")


def test_another_source_than_that_of_the_run_is_refused(stored: Path, tmp_path: Path) -> None:
    other = tmp_path / "mine.py"
    other.write_text((stored.parent / "mine.py").read_text().replace("here", "there"))

    with pytest.raises(RecordError, match=r"was made with other source than '.*mine\.py:Mine' has now"):
        run_again(stored, tmp_path / "again", manager=f"{other}:Mine")


@pytest.mark.parametrize("manager", ["reactive", pytest.param("random", marks=pytest.mark.thorough)])
def test_commands_that_are_played_back_make_the_same_images(manager: str, tmp_path: Path) -> None:
    scenario = load_scenario("camera_driver_issue+image_degradation")
    run(RunSpec(scenario=scenario, manager=manager, seed=2), tmp_path / "run")
    wanted = {"/gt_segmentation", "/managed_subsystem/sensors_fused/depth"}

    assert play_back(tmp_path / "run", tmp_path / "played", wanted=wanted.__contains__) == 0

    assert {image.topic for image in read_images(tmp_path / "played")} == wanted


def test_images_that_the_commands_do_not_make_are_counted(stored: Path, tmp_path: Path) -> None:
    folder = rewritten(stored, tmp_path / "other", seed=6)

    assert play_back(folder, tmp_path / "played") > 0


def test_what_it_was_made_with_may_lie_elsewhere(stored: Path, tmp_path: Path) -> None:
    source = stored.parent / "mine.py"
    moved = source.rename(tmp_path / "mine.py")
    try:
        again = run_again(stored, tmp_path / "again", manager=f"{moved}:Mine", model="lite")
    finally:
        moved.rename(source)

    assert again.digest == read_run(stored).digest


def test_what_differs_is_named(stored: Path, tmp_path: Path) -> None:
    versions = read_run(stored).versions | {"numpy": "0.1"}
    folder = rewritten(stored, tmp_path / "other", seed=6, versions=versions)

    with pytest.raises(
        RecordError,
        match=r"left other messages, first at -.* s on /.*; what differs: numpy 0\.1 is [0-9.]+\. Name",
    ):
        run_again(folder, tmp_path / "again", trust=True)
    folder = rewritten(stored, tmp_path / "seed", seed=7)
    with pytest.raises(RecordError, match="what differs: the record itself"):
        run_again(folder, tmp_path / "again too", trust=True)


def test_another_flight_is_found_before_anything_is_run(stored: Path, flight: Path, tmp_path: Path) -> None:
    reader = read_bag(flight)
    frames = [reader.frame(number) for number in range(30)]
    write_bag(tmp_path / "bag", frames, [number * 10**8 for number in range(30)])

    with pytest.raises(
        RecordError, match=r"other frames than the bag .*bag has; name its own bag with --bag"
    ):
        run_again(stored, tmp_path / "again", trust=True, bag=tmp_path / "bag")


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        ({"middleware": "cyclonedds"}, "was live, on cyclonedds, and only runs of the simulation"),
        ({"manager_failed": "it raised", "start_ns": UNSET}, "it failed, and left no messages"),
        ({"extensions": {"rain.py": "0"}}, "made with the extension rain.py"),
    ],
)
def test_what_cannot_be_run_again_is_refused(
    changed: dict[str, object], expected: str, stored: Path, tmp_path: Path
) -> None:
    folder = rewritten(stored, tmp_path / "other", **changed)

    with pytest.raises(RecordError, match=expected):
        run_again(folder, tmp_path / "again", trust=True)
