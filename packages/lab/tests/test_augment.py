"""Augmentation, against OpenCV's; and steps of a training on a device that stands for an accelerator."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest

from sunset.errors import InvalidInputError, MissingExtraError
from sunset_lab import FrameSet, Schedule, TrainingConfig
from sunset_lab.config import Phase
from sunset_lab.frames import FrameSets
from sunset_lab.shapes import LiteShape

pytestmark = pytest.mark.thorough

torch = pytest.importorskip("torch")

from torch.utils._python_dispatch import TorchDispatchMode  # noqa: E402  needs torch

from sunset_lab.augment import DeviceFrames, draw  # noqa: E402
from sunset_lab.network import build, depth_input, forward, rgb_input, upsample  # noqa: E402
from sunset_lab.run import find_torch_device, learn  # noqa: E402
from sunset_lab.stage import Training  # noqa: E402

TINY = TrainingConfig(
    shape=LiteShape(16, (16, 16, 16), (1, 1, 1), pyramid=16, rates=(2,), skips=(16, 16), decoder=16),
    schedule=Schedule(phases=(Phase(6, 2),), log_every=3, validate_every=6),
)
Array = npt.NDArray[Any]
CPU = torch.device("cpu")
SIZE = (256, 144)


def noise(count: int) -> FrameSet:
    rng = np.random.default_rng(0)
    depth = rng.integers(0, 2**16, (count, 144, 256), dtype=np.uint16)
    return FrameSet(
        rng.integers(0, 256, (count, 144, 256, 3), dtype=np.uint8), depth, (depth % 28).astype(np.uint8)
    )


def test_a_batch_is_what_opencv_makes_of_the_same_draw() -> None:
    frames = noise(6)
    to_corners = np.array([[2 / 256, 0, 1 / 256 - 1], [0, 2 / 144, 1 / 144 - 1], [0, 0, 1]])
    for number in range(8):
        drawn = draw(6, 4, 1, number)
        batch = DeviceFrames(frames, CPU).batch(drawn)
        for place, (index, transform, gain) in enumerate(
            zip(drawn.frames, drawn.transforms, drawn.gains, strict=True)
        ):
            between_corners = np.vstack([transform, (0, 0, 1)])
            matrix = (np.linalg.inv(to_corners) @ between_corners @ to_corners)[:2]

            def warped(image: Array, interpolation: int, matrix: Array = matrix) -> Array:
                flags = interpolation | cv2.WARP_INVERSE_MAP
                picture: Array = cv2.warpAffine(
                    image, matrix, SIZE, flags=flags, borderMode=cv2.BORDER_REPLICATE
                )
                return picture

            colours = cv2.convertScaleAbs(warped(frames.bgr[index], cv2.INTER_LINEAR), alpha=float(gain))
            difference = np.abs(batch.bgr[place].numpy().astype(int) - colours)
            assert difference.max() <= 2  # of rounding, twice
            assert (difference > 0).mean() < 0.001
            for found, image in ((batch.depth, frames.depth), (batch.labels, frames.labels)):
                expected = warped(image[index], cv2.INTER_NEAREST)
                assert (
                    found[place].numpy() != expected
                ).mean() < 0.02  # a row or a column half-way between two
        assert batch.phase == drawn.phase


def test_augmentation_moves_colour_depth_and_labels_alike(sets: FrameSets) -> None:
    batch = DeviceFrames(sets.train, CPU).batch(draw(12, 20, 1, 0))
    assert torch.equal(batch.depth, 2500 + 60 * batch.labels.float())


def test_augmentation_mirrors_half_and_enlarges_half_of_the_frames() -> None:
    x = np.arange(256, dtype=np.uint16) * np.ones((1, 144, 1), dtype=np.uint16)
    plain = FrameSet(np.full((1, 144, 256, 3), 100, np.uint8), x, np.zeros((1, 144, 256), np.uint8))
    batch = DeviceFrames(plain, CPU).batch(draw(1, 200, 1, 0))
    left, right = batch.depth[:, 70, 0], batch.depth[:, 70, 255]
    assert 70 < (left > right).sum() < 130
    assert 70 < ((left - right).abs() < 255).sum() < 130
    assert (left - right).abs().min() >= 255 / 1.31
    gains = batch.bgr[:, 0, 0, 0]
    assert 90 <= gains.min() < 95
    assert 105 < gains.max() <= 110


def test_depth_beyond_half_its_range_is_not_negative() -> None:
    frames = noise(3)
    plain = DeviceFrames(frames, CPU).plain(np.array([2, 0]))
    assert np.array_equal(plain.depth, frames.depth[[2, 0]])
    assert np.array_equal(plain.bgr, frames.bgr[[2, 0]])
    assert np.array_equal(plain.labels, frames.labels[[2, 0]])


def test_read_only_frames_can_be_learned_from(sets: FrameSets) -> None:
    labels = sets.train.labels.copy()
    labels.flags.writeable = False
    assert len(DeviceFrames(replace(sets.train, labels=labels), CPU)) == len(labels)


def test_what_a_step_computes_is_on_the_frames_device_and_never_waited_for() -> None:
    device = torch.device("meta")  # has no values to wait for, and takes no tensor of another
    batch = DeviceFrames(noise(4), device).batch(draw(4, 3, 1, 0))
    plan = TINY.plan(TINY.modalities)
    modules = build(plan).to(device)
    results = {"rgb.input": rgb_input(batch.bgr), "depth.input": depth_input(batch.depth)}
    forward(plan, modules, results)
    logits = upsample(results["fusion.logits"], 2, batch.phase, 2)
    loss = torch.nn.functional.cross_entropy(logits, batch.labels[:, ::2, ::2], torch.ones(28, device=device))
    loss.backward()
    assert all(parameter.grad.device == device for parameter in modules.parameters())


def test_constants_are_sent_to_a_device_once() -> None:
    device = torch.device("meta")
    maps = torch.zeros(1, 28, 18, 32, device=device)
    frames = torch.zeros(1, 144, 256, 3, dtype=torch.uint8, device=device)
    sent = {"aten.lift_fresh", "aten.copy_"}
    cases: list[tuple[Callable[[], Any], set[str]]] = [
        (lambda: upsample(maps, 8), sent | {"aten._to_copy"}),
        (lambda: rgb_input(frames), sent),
    ]
    for compute, sending in cases:
        compute()
        with operations() as seen:
            compute()
        assert seen.names
        assert not sending & set(seen.names)


def operations() -> Any:
    """Return a context that writes down the names of torch's operations."""

    def note(mode: Any, operation: Any, _: Any, arguments: Any = (), options: Any = None) -> Any:
        mode.names.append(str(operation.overloadpacket))
        return operation(*arguments, **(options or {}))

    return type("Operations", (TorchDispatchMode,), {"names": [], "__torch_dispatch__": note})()


def test_only_a_line_of_the_log_and_a_checkpoint_wait_for_the_device(sets: FrameSets, tmp_path: Path) -> None:
    read: list[int] = []
    seen = operations()

    def progress(*_: object) -> None:
        drawn = ("aten.randint", "aten.random_")  # on the CPU, for the misaligned pairs
        waits = [
            name
            for before, name in zip(["", *seen.names], seen.names, strict=False)
            if name == "aten._local_scalar_dense" and before not in drawn
        ]
        read.append(len(waits))
        seen.names.clear()

    with seen:
        float(torch.zeros(()))
        assert seen.names[-1] == "aten._local_scalar_dense"  # so would a step show that waits
        learn(Training(TINY, tmp_path, progress=progress), sets.train, sets.validation)
    assert read[1] == read[3] == read[4] == 0


def test_the_networks_can_be_compiled_in_one_piece() -> None:
    plan = TINY.plan(("rgb",))
    modules = build(plan).eval()
    inputs = {"rgb.input": torch.randn(1, 3, 144, 256)}
    expected, found = dict(inputs), dict(inputs)
    with torch.no_grad():
        forward(plan, modules, expected)
        torch.compile(forward, backend="eager", fullgraph=True)(plan, modules, found)
    assert torch.equal(expected["rgb.logits"], found["rgb.logits"])


@pytest.mark.skipif(torch.cuda.is_available(), reason="there is a device")
def test_a_device_that_is_not_there_is_refused() -> None:
    assert find_torch_device("auto") == find_torch_device("cpu") == CPU
    with pytest.raises(
        MissingExtraError, match="finds none: install another torch, or choose the device cpu"
    ):
        find_torch_device("cuda")
    with pytest.raises(InvalidInputError, match="must be one of cpu, cuda, auto, got 'tpu'"):
        find_torch_device("tpu")


@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs an accelerator")
def test_an_accelerator_learns(sets: FrameSets, tmp_path: Path) -> None:
    modules = learn(Training(TINY, tmp_path, device="cuda"), sets.train, sets.validation)
    assert {parameter.device.type for parameter in modules.parameters()} == {"cpu"}
