"""A training that is interrupted in every phase, by signals that can and cannot be held back."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from sunset.training import FrameSet, FrameSets

pytest.importorskip("torch")
pytest.importorskip("onnx")

pytestmark = [pytest.mark.thorough, pytest.mark.xdist_group("interruption")]

PROGRAM = """
import os
import signal
import sys
from pathlib import Path

import torch

from sunset.cli._main import _interrupt
from sunset.training import FrameSet, FrameSets, LiteShape, Phase, Schedule, TrainingConfig, stage, train_on
from sunset.training.frames import Views, render_set

SHAPE = LiteShape(16, (16, 16, 16), (1, 1, 1), pyramid=16, rates=(2,), skips=(16, 16), decoder=16)
SCHEDULE = Schedule(phases=(Phase(6, 2),), warm_up=2, log_every=4, validate_every=4)
PLAN = tuple(Views(3, 1, seed, flight=True) for seed in (1, 2, 3))

def progress(what, done, total, note=""):
    print(what, done, sep=":", flush=True)
    if (what, done) == (sys.argv[2], int(sys.argv[3])):
        os.kill(os.getpid(), int(sys.argv[4]))

if __name__ == "__main__":
    torch.set_num_threads(1)
    signal.signal(signal.SIGTERM, _interrupt)
    stage.CHECKPOINT_EVERY_S = 0.0
    folder, sets = Path(sys.argv[1]), Path(sys.argv[5])
    if not sets.exists():
        render_set(PLAN, folder, jobs=1, progress=lambda done, total: progress("frames", done, total))
        sys.exit()
    train_on(
        TrainingConfig("tiny", shape=SHAPE, schedule=SCHEDULE),
        FrameSets(*(FrameSet.load(sets / str(number)) for number in range(5))),
        folder / "model",
        work=folder / "work",
        resume=True,
        progress=progress,
    )
"""
NO_SETS = Path("none")
ENDED = {0: 0, signal.SIGTERM: -signal.SIGINT, signal.SIGKILL: -signal.SIGKILL}  # Python ends as after Ctrl-C


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("program") / "program.py"
    path.write_text(PROGRAM, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def frames(sets: FrameSets, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sets")
    for place, name in enumerate(("train", "validation", "validation_flight", "test", "test_flight")):
        one = getattr(sets, name)
        FrameSet(one.bgr[:5], one.depth[:5], one.labels[:5]).save(folder / str(place))
    return folder


@pytest.fixture(scope="module")
def undisturbed(program: Path, frames: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """The networks of a training that nothing interrupts."""
    folder = tmp_path_factory.mktemp("whole")
    run(program, folder, frames)
    return networks_of(folder)


@pytest.fixture(scope="module")
def rendered(program: Path, tmp_path_factory: pytest.TempPathFactory) -> str:
    """The digest of frames whose rendering nothing interrupts."""
    folder = tmp_path_factory.mktemp("whole")
    run(program, folder, NO_SETS)
    return FrameSet.load(folder).digest()


def networks_of(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (folder / "model").glob("*.[ob]*")}


def run(program: Path, folder: Path, sets: Path, at: tuple[str, int] = ("", 0), number: int = 0) -> list[str]:
    """Train, or render if there are no frames; when something was done so often, it gets a signal.

    Returns:
        What was done.
    """
    command = [sys.executable, str(program), str(folder), at[0], str(at[1]), str(number), str(sets)]
    process = subprocess.run(command, capture_output=True, text=True, check=False)
    assert process.returncode == ENDED[number], process.stderr
    return process.stdout.split("\n")[:-1]


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL], ids=["SIGTERM", "SIGKILL"])
def test_an_interrupted_training_repeats_nothing_that_is_kept_and_gives_the_same_networks(
    number: int, program: Path, frames: Path, undisturbed: dict[str, bytes], tmp_path: Path
) -> None:
    parts = tmp_path / "parts"
    at = [("networks", 3), ("Measuring int8", 1), ("Measuring", 3), ("Measuring on the test town", 1)]
    runs = [run(program, parts, frames, place, number) for place in at]
    assert not (parts / "model").exists()
    runs.append(run(program, parts, frames))
    learned = [line for lines in runs for line in lines if line.startswith("networks:")]
    steps = [f"networks:{step}" for step in range(1, 7)]
    if number == signal.SIGKILL:  # it came before the step's checkpoint was written
        assert learned == [*steps[:3], *steps[2:]]
    else:  # the step in which it came was ended, and perhaps not told of
        assert learned in (steps, steps[:3] + steps[4:])
    assert not list((parts / "work").glob("finish*"))
    assert {"rgb.onnx", "depth.onnx", "fusion.onnx"} <= set(undisturbed)
    assert networks_of(parts) == undisturbed


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL], ids=["SIGTERM", "SIGKILL"])
def test_interrupted_rendering_goes_on_with_what_is_missing(
    number: int, program: Path, rendered: str, tmp_path: Path
) -> None:
    assert run(program, tmp_path, NO_SETS, ("frames", 2), number) == ["frames:1", "frames:2"]
    assert run(program, tmp_path, NO_SETS) == ["frames:3"]
    assert FrameSet.load(tmp_path).digest() == rendered
