"""A training that is interrupted in every phase, by signals that can and cannot be held back."""

import json
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from sunset_lab import FrameSet
from sunset_lab.frames import FrameSets

pytest.importorskip("torch")
pytest.importorskip("onnx")

pytestmark = [pytest.mark.thorough, pytest.mark.xdist_group("interruption")]

TRAINING = """
import json
import os
import signal
import sys
from pathlib import Path

import matplotlib.pyplot  # what a training imports takes longer than the training
import onnx
import torch._dynamo

from sunset.cli._main import _interrupt
from sunset_lab import FrameSet, Schedule, TrainingConfig, stage
from sunset_lab.config import Phase
from sunset_lab.frames import FrameSets
from sunset_lab.shapes import LiteShape
from sunset_lab.run import train_on
from sunset_lab.stage import Training

SHAPE = LiteShape(16, (16, 16, 16), (1, 1, 1), pyramid=16, rates=(2,), skips=(16, 16), decoder=16)
SCHEDULE = Schedule(phases=(Phase(6, 2),), warm_up=2, log_every=4, validate_every=4)

def train(folder, sets, at, number):
    def progress(what, done, total, note=""):
        print(what, done, sep=":", flush=True)
        if [what, done] == at:
            os.kill(os.getpid(), number)

    torch.set_num_threads(1)
    signal.signal(signal.SIGTERM, _interrupt)
    stage.CHECKPOINT_EVERY_S = 0.0
    config = TrainingConfig("tiny", shape=SHAPE, schedule=SCHEDULE)
    train_on(
        Training(config, Path(folder) / "work", resume=True, progress=progress),
        FrameSets(*(FrameSet.load(Path(sets) / str(number)) for number in range(4))),
        Path(folder) / "model",
    )

work = train
"""
RENDERING = """
import json
import os
import signal
import sys
from pathlib import Path

from sunset.cli._main import _interrupt
from sunset_town.town import build_town
from sunset_lab.frames import Views, render_set

PLAN = tuple(Views(3, 1, seed, flight=True) for seed in (1, 2, 3))
build_town(3)  # takes longer than the rendering

def render(folder, at, number):
    def progress(done, total):
        print("frames", done, sep=":", flush=True)
        if done == at:
            os.kill(os.getpid(), number)

    signal.signal(signal.SIGTERM, _interrupt)
    render_set(PLAN, Path(folder), jobs=1, progress=progress)

work = render
"""
SERVING = """
for line in sys.stdin:
    pid = os.fork()
    if pid == 0:
        work(*json.loads(line))
        sys.exit()
    print("code", os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]), sep=":", flush=True)
"""
ENDED = {0: 0, signal.SIGTERM: -signal.SIGINT, signal.SIGKILL: -signal.SIGKILL}  # Python ends as after Ctrl-C

Train = Callable[..., list[str]]
Render = Callable[..., list[str]]


@contextmanager
def serving(program: str) -> Iterator[Callable[..., list[str]]]:
    """Give what lets a program work in a process of its own, which may get a signal, and returns what it printed."""
    command = [sys.executable, "-c", program + SERVING]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as server:
        asked, told = server.stdin, server.stdout
        assert asked is not None
        assert told is not None

        def work(*arguments: object, number: int) -> list[str]:
            print(json.dumps([*arguments, number]), file=asked, flush=True)
            lines = []
            for line in told:
                lines.append(line.rstrip())
                if lines[-1].startswith("code:"):
                    break
            assert lines.pop() == f"code:{ENDED[number]}"
            return lines

        yield work


@pytest.fixture(scope="module")
def train(sets: FrameSets, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Train]:
    """Train in a process of its own; when something was done so often, it gets a signal. Return what was done."""
    frames = tmp_path_factory.mktemp("sets")
    for place, name in enumerate(("train", "validation", "validation_flight", "test")):
        one = getattr(sets, name)
        FrameSet(one.bgr[:5], one.depth[:5], one.labels[:5]).save(frames / str(place))
    with serving(TRAINING) as work:

        def once(folder: Path, at: tuple[str, int] = ("", 0), number: int = 0) -> list[str]:
            return work(str(folder), str(frames), at, number=number)

        yield once


@pytest.fixture(scope="module")
def undisturbed(train: Train, tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """The networks of a training that nothing interrupts."""
    folder = tmp_path_factory.mktemp("whole")
    train(folder)
    return networks_of(folder)


@pytest.fixture(scope="module")
def render() -> Iterator[Render]:
    """Render in a process of its own; when so many frames are done, it gets a signal. Return what was done."""
    with serving(RENDERING) as work:

        def once(folder: Path, at: int = 0, number: int = 0) -> list[str]:
            return work(str(folder), at, number=number)

        yield once


@pytest.fixture(scope="module")
def rendered(render: Render, tmp_path_factory: pytest.TempPathFactory) -> str:
    """The digest of frames whose rendering nothing interrupts."""
    folder = tmp_path_factory.mktemp("whole")
    render(folder)
    return FrameSet.load(folder).digest()


def networks_of(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (folder / "model").glob("*.[ob]*")}


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL], ids=["SIGTERM", "SIGKILL"])
def test_an_interrupted_training_repeats_nothing_that_is_kept_and_gives_the_same_networks(
    number: int, train: Train, undisturbed: dict[str, bytes], tmp_path: Path
) -> None:
    parts = tmp_path / "parts"
    at = [("networks", 3), ("Measuring int8", 1), ("Measuring", 3), ("Measuring on the test town", 1)]
    runs = [train(parts, place, number) for place in at]
    assert not (parts / "model").exists()
    runs.append(train(parts))
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
    number: int, render: Render, rendered: str, tmp_path: Path
) -> None:
    assert render(tmp_path, 2, number) == ["frames:1", "frames:2"]
    assert render(tmp_path) == ["frames:3"]
    assert FrameSet.load(tmp_path).digest() == rendered
