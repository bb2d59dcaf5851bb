import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from sunset.errors import DataError, InvalidInputError, OutputError, SunsetError
from sunset.perception import Modality, Model, Segmenter
from sunset_lab import FrameSet, Schedule, TrainingConfig
from sunset_lab.config import Phase
from sunset_lab.frames import FrameSets
from sunset_lab.shapes import LiteShape, ReferenceShape

pytestmark = pytest.mark.thorough

torch = pytest.importorskip("torch")
pytest.importorskip("onnx")

from sunset_lab import run  # noqa: E402  needs torch
from sunset_lab.augment import class_weights  # noqa: E402
from sunset_lab.network import (  # noqa: E402
    build,
    forward,
    shift_logits,
    start_from_the_sum,
    upsample,
)
from sunset_lab.stage import Training  # noqa: E402

torch.set_num_threads(1)  # the networks are tiny, and other tests run beside

TINY = TrainingConfig(
    name="tiny",
    shape=LiteShape(16, (16, 16, 16), (1, 1, 1), pyramid=16, rates=(2,), skips=(16, 16), decoder=16),
    schedule=Schedule(
        phases=(Phase(6, 2),),
        learning_rate=5e-3,
        warm_up=2,
        log_every=2,
        validate_every=4,
    ),
)
PHASES = replace(TINY.schedule, phases=(Phase(2, 2, output_stride=32), Phase(2, 3, 16), Phase(2, 2)))
NARROW = TrainingConfig(
    name="narrow",
    shape=ReferenceShape(16, (1, 1, 1, 1), pyramid=16),
    schedule=PHASES,
    merging=replace(TINY.schedule, distinct=4),
)


def learn(config: TrainingConfig, frames: FrameSet, validation: FrameSet, work: Path, **options: Any) -> Any:
    return run.learn(Training(config, work, **options), frames, validation)


def train_on(config: TrainingConfig, sets: FrameSets, out: Path, *, work: Path, **options: Any) -> Model:
    return run.train_on(Training(config, work, **options), sets, out)


def train(config: TrainingConfig, out: Path, *, work: Path, **options: Any) -> Model:
    return run.train(Training(config, work, **options), out)


def log_of(folder: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (folder / "log.jsonl").read_text("utf-8").splitlines()]


def few(frames: FrameSet) -> FrameSet:
    return FrameSet(frames.bgr[:5], frames.depth[:5], frames.labels[:5])


@pytest.fixture(scope="module")
def small(sets: FrameSets) -> FrameSets:
    """As many frames to measure on as a calibration needs."""
    return FrameSets(sets.train, few(sets.validation), few(sets.validation_flight), few(sets.test))


class Trained(NamedTuple):
    """A model, the folder of its training, and the progress that was told."""

    model: Model
    work: Path
    calls: list[tuple[str, int, int]]


def trained(config: TrainingConfig, small: FrameSets, folder: Path) -> Trained:
    """Train, or go on with a training."""
    calls: list[tuple[str, int, int]] = []
    model = train_on(
        config,
        small,
        folder / config.name,
        work=folder / "work",
        resume=(folder / "work").exists(),
        progress=lambda what, done, total, _="": calls.append((what, done, total)),
    )
    return Trained(model, folder / "work", calls)


@pytest.fixture(scope="module")
def lite(small: FrameSets, tmp_path_factory: pytest.TempPathFactory) -> Trained:
    """A small network of the kind `lite`."""
    return trained(TINY, small, tmp_path_factory.mktemp("lite"))


class Reference(NamedTuple):
    """A small network of the kind of the reference, and its first branch, which was learned before."""

    trained: Trained
    branch: Any


@pytest.fixture(scope="module")
def reference(small: FrameSets, tmp_path_factory: pytest.TempPathFactory) -> Reference:
    folder = tmp_path_factory.mktemp("reference")
    branch = learn(replace(NARROW, modalities=("rgb",)), small.train, small.validation, folder / "work")
    return Reference(trained(NARROW, small, folder), branch)


@pytest.mark.xdist_group("trained")
def test_a_run_writes_a_model_with_its_card_log_and_figure(lite: Trained, small: FrameSets) -> None:
    model, work, calls = lite
    assert calls[:6] == [("networks", step, 6) for step in range(1, 7)]
    assert model.card.name == "tiny"
    assert (model.card.architecture, model.card.precision) == ("lite", "int8")
    assert set(model.card.networks) == set(Modality)
    assert 0 < model.card.entropy_threshold < 1
    assert (model.folder / "card.md").read_text(encoding="utf-8").startswith("# tiny, version ")
    lines = log_of(work / "networks")
    assert [line["step"] for line in lines] == [2, 4, 6]
    assert all(line[name] > 0 for line in lines for name in ("rgb", "depth", "fusion", "misaligned"))
    assert ["iou" in line for line in lines] == [False, True, True]
    assert set(lines[-1]["iou"]) == {"rgb", "depth", "fusion"}
    segmenter = Segmenter(model)
    flight = small.validation_flight
    means = [
        np.mean([segmenter.segment(m, *pair).entropy for pair in zip(flight.bgr, flight.depth, strict=True)])
        for m in Modality
    ]
    assert means == pytest.approx([means[0]] * 3, abs=2e-3)  # one threshold serves all networks


@pytest.mark.xdist_group("trained")
def test_branches_learned_one_by_one_are_merged_as_they_are(reference: Reference, small: FrameSets) -> None:
    (model, work, calls), rgb = reference
    assert [what for what, done, total in calls if done == 1 and total == 6] == ["depth", "fusion"]
    whole = learn(NARROW, small.train, small.validation, work, resume=True).state_dict()
    for name, value in rgb.state_dict().items():
        assert torch.equal(whole[name], value)
    assert set(model.card.networks) == set(Modality)
    stages: Any = model.card.training["stages"]
    assert stages["fusion"]["started_from"] == "rgb and depth, frozen"
    assert [stages[name]["started_from"] for name in ("rgb", "depth")] == ["random weights", "rgb"]
    assert stages["rgb"]["schedule"]["steps"] == 6
    measured: Any = model.card.results["iou_by_precision_on_the_validation_town"]
    assert set(measured["fusion"]) == {"float32", "int8"}


def test_the_second_branch_begins_with_the_first_ones_weights(sets: FrameSets, tmp_path: Path) -> None:
    unmoved = replace(NARROW, schedule=replace(PHASES, learning_rate=0.0))
    known = learn(unmoved, sets.train, few(sets.validation), tmp_path).state_dict()
    kernels = [name for name, value in known.items() if name.startswith("rgb.") and value.ndim > 1]
    assert len(kernels) > 10
    assert all(torch.equal(known[name.replace("rgb.", "dth.", 1)], known[name]) for name in kernels)


@pytest.mark.xdist_group("trained")
@pytest.mark.parametrize("config", [TINY, NARROW], ids=["lite", "reference"])
def test_a_training_goes_on_where_a_model_was(
    config: TrainingConfig, lite: Trained, reference: Reference, small: FrameSets, tmp_path: Path
) -> None:
    start = (lite if config is TINY else reference.trained).model
    still = Schedule(phases=(Phase(1, 2, momentum=1e-9),), learning_rate=0.0)
    unmoved = replace(config, schedule=still, merging=config.merging and still, seed=config.seed + 1)
    model = train_on(unmoved, small, tmp_path / "out", work=tmp_path / "on", start=start)
    frame = small.test.bgr[0], small.test.depth[0]
    for modality in Modality:
        before, after = (Segmenter(each).logits(modality, *frame) for each in (start, model))
        assert np.abs(after - before).max() < 0.1 * np.abs(before).max()  # rounded to 8 bits twice
        assert np.abs(before).max() > 0.1
    facts: Any = model.card.training
    assert facts["before"] == dict(start.card.training)
    origins = {name: stage["started_from"] for name, stage in facts["stages"].items()}
    assert origins.pop("fusion", "rgb and depth, frozen") == "rgb and depth, frozen"
    assert set(origins.values()) == {f"{config.name}, version {start.card.version}"}


def test_a_training_does_not_start_from_other_networks(small: FrameSets, tmp_path: Path) -> None:
    depth = replace(TINY, modalities=("depth",)).with_steps(1)
    start = train_on(depth, small, tmp_path / "start", work=tmp_path / "work")
    wide = replace(depth, shape=replace(TINY.shape, pyramid=32))
    for config, why in (
        (TINY, "it has no network 'rgb'"),
        (
            replace(NARROW, modalities=("depth",)),
            r"its network 'depth' has no such layer dth\.backbone\.conv1",
        ),
        (wide, r"its network 'depth' has no such layer depth\.\w+"),
    ):
        with pytest.raises(InvalidInputError, match=f"cannot start from the model 'tiny': {why}"):
            train(config, tmp_path / "out", work=tmp_path / "other", start=start)
    assert not (tmp_path / "out").exists()


def test_a_start_from_other_weights_is_another_training(small: FrameSets, tmp_path: Path) -> None:
    depth = replace(TINY, modalities=("depth",)).with_steps(1)
    start = train_on(depth, small, tmp_path / "start", work=tmp_path / "work")
    with pytest.raises(InvalidInputError, match="is of another training"):
        train_on(depth, small, tmp_path / "out", work=tmp_path / "work", start=start, resume=True)


def test_the_fusion_of_learned_branches_begins_as_about_their_sum() -> None:
    modules = build(NARROW.plan(("fusion",)))
    start_from_the_sum(modules)
    rgb, depth = 5 * torch.randn(2, 1, 28, 18, 32)
    results = {"rgb.logits": rgb, "depth.logits": depth}
    with torch.no_grad():
        forward(NARROW.plan(("fusion",)), modules, results)
        expected = upsample(0.6 * (rgb + depth), 8)
    assert (results["fusion.logits"] - expected).abs().mean() < 0.3 * expected.abs().mean()


@pytest.mark.parametrize("config", [TINY, NARROW], ids=["lite", "reference"])
def test_every_networks_logits_are_shifted_once(config: TrainingConfig) -> None:
    modules = build(config.plan(config.modalities)).eval()
    frames = dict(zip(("rgb.input", "depth.input"), torch.randn(2, 1, 3, 144, 256), strict=True))
    shift = torch.randn(28)

    def logits() -> dict[str, Any]:
        results = dict(frames)
        with torch.no_grad():
            forward(config.plan(config.modalities), modules, results)
        return {name: results[f"{name}.logits"] for name in config.modalities}

    before = logits()
    shift_logits({name: config.plan((name,)) for name in config.modalities}, modules, shift.numpy())
    for name, after in logits().items():
        torch.testing.assert_close(after, before[name] + shift[:, None, None], atol=1e-4, rtol=0)


def test_the_adjustment_takes_a_share_of_the_class_weights_off_the_logits(
    small: FrameSets, tmp_path: Path
) -> None:
    config = replace(TINY, modalities=("rgb",), logit_adjustment=0.5)
    raw = learn(replace(config, logit_adjustment=0), small.train, small.validation, tmp_path)
    adjusted = learn(config, small.train, small.validation, tmp_path, resume=True)
    labels = np.asarray(small.train.labels[:: max(1, len(small.train) // 500)])
    expected = -0.5 * np.log(class_weights(labels, config.schedule.class_weight_range))
    bias = "rgb.classifier.conv.bias"
    difference = adjusted.state_dict()[bias] - raw.state_dict()[bias]
    assert difference.reshape(28, 4).numpy() == pytest.approx(np.repeat(expected, 4).reshape(28, 4), abs=1e-6)


def test_one_branch_alone_makes_a_model(small: FrameSets, tmp_path: Path) -> None:
    config = replace(TINY, modalities=("depth",))
    model = train_on(config, small, tmp_path / "out", work=tmp_path / "work")
    assert list(model.card.networks) == [Modality.DEPTH]


@pytest.mark.parametrize(
    "config", [TINY, replace(NARROW, modalities=("rgb",)), NARROW], ids=["lite", "reference", "merging"]
)
def test_a_resumed_run_learns_what_an_undisturbed_one_learns(
    config: TrainingConfig, small: FrameSets, tmp_path: Path
) -> None:
    whole = learn(config, small.train, small.validation, tmp_path / "whole")
    last = config.stages()[-1].name

    def stop(what: str, done: int, _: int, __: str = "") -> None:
        if (what, done) == (last, 5):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        learn(config, small.train, small.validation, tmp_path / "parts", progress=stop)
    resumed = learn(config, small.train, small.validation, tmp_path / "parts", resume=True)
    for name, value in whole.state_dict().items():
        assert torch.equal(value, resumed.state_dict()[name]), name
    logs = [log_of(tmp_path / part / last) for part in ("whole", "parts")]
    for log in logs:
        for line in log:
            del line["seconds"]
    assert logs[0] == logs[1]
    assert [line["step"] for line in logs[0]] == [2, 4, 6]


def test_learning_lowers_the_loss(small: FrameSets, tmp_path: Path) -> None:
    learn(TINY.with_steps(30), small.train, small.validation, tmp_path)
    lines = log_of(tmp_path / "networks")
    for name in ("rgb", "depth", "fusion"):
        assert lines[-1][name] < 0.9 * lines[0][name]


def test_the_checkpoint_of_another_run_is_refused(small: FrameSets, tmp_path: Path) -> None:
    learn(TINY.with_steps(1), small.train, small.validation, tmp_path)
    with pytest.raises(
        InvalidInputError,
        match=r"is of another training: they differ in --steps \(begun with 1, asked for 6\); choose",
    ):
        learn(TINY, small.train, small.validation, tmp_path, resume=True)


def test_a_checkpoint_of_other_frames_is_refused(small: FrameSets, tmp_path: Path) -> None:
    config = replace(TINY, modalities=("depth",)).with_steps(1)
    learn(config, small.train, small.validation, tmp_path)
    brighter = replace(small.train, bgr=small.train.bgr + np.uint8(1))
    with pytest.raises(
        InvalidInputError, match=r"is of another training: they differ in --frames \(begun with"
    ):
        learn(config, brighter, small.validation, tmp_path, resume=True)


def test_a_damaged_checkpoint_is_named(small: FrameSets, tmp_path: Path) -> None:
    config = replace(TINY, modalities=("depth",)).with_steps(1)
    learn(config, small.train, small.validation, tmp_path)
    checkpoint = tmp_path / "networks" / "checkpoint.pt"
    whole = checkpoint.read_bytes()
    middle = len(whole) // 2
    flipped = whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :]
    for content in (b"", whole[:1000], whole[:-1000], b"PK" + whole[2:5000], flipped):
        checkpoint.write_bytes(content)
        with pytest.raises(DataError, match=r"checkpoint\.pt is damaged: delete it, and train again\."):
            learn(config, small.train, small.validation, tmp_path, resume=True)


def test_a_training_is_not_begun_where_there_is_one(small: FrameSets, tmp_path: Path) -> None:
    config = replace(TINY, modalities=("depth",))
    learn(config, small.train, small.validation, tmp_path)
    log = (tmp_path / "networks" / "log.jsonl").read_text(encoding="utf-8")
    with pytest.raises(InvalidInputError, match="holds a training already: go on with it"):
        learn(config, small.train, small.validation, tmp_path)
    assert (tmp_path / "networks" / "log.jsonl").read_text(encoding="utf-8") == log


def test_a_branch_is_not_merged_by_what_was_learned_on_another(sets: FrameSets, tmp_path: Path) -> None:
    learn(NARROW, sets.train, few(sets.validation), tmp_path)
    checkpoint = tmp_path / "rgb" / "checkpoint.pt"
    state = torch.load(checkpoint, weights_only=True)
    state["modules"]["rgb.backbone.conv1.weight"] += 1
    torch.save(state, checkpoint)
    with pytest.raises(InvalidInputError, match=r"depth/checkpoint\.pt is of another training"):
        learn(NARROW, sets.train, few(sets.validation), tmp_path, resume=True)


def test_a_training_that_diverges_ends(sets: FrameSets, tmp_path: Path) -> None:
    config = replace(TINY, schedule=replace(TINY.schedule, learning_rate=1e30, warm_up=1))
    with pytest.raises(SunsetError, match="The training of networks diverged at step"):
        learn(config, sets.train, sets.validation, tmp_path)


def test_a_line_of_the_log_that_was_being_written_is_dropped(small: FrameSets, tmp_path: Path) -> None:
    learn(TINY, small.train, small.validation, tmp_path)
    log = tmp_path / "networks" / "log.jsonl"
    whole = log.read_text(encoding="utf-8")
    log.write_text(f'{whole}{{"step": 7, "rgb', encoding="utf-8")
    learn(TINY, small.train, small.validation, tmp_path, resume=True)
    assert log.read_text(encoding="utf-8") == whole


def test_the_output_folder_is_tried_before_hours_of_work(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("", encoding="utf-8")
    with pytest.raises(OutputError, match=r"The training cannot write to .*out: Not a directory"):
        train(TINY, tmp_path / "out", work=tmp_path / "work")
    assert not (tmp_path / "work").exists()


def test_a_folder_that_cannot_be_written_is_named(sets: FrameSets, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(OutputError, match="The training cannot write to"):
        train_on(TINY.with_steps(1), sets, tmp_path / "out", work=tmp_path / "file" / "work")


def test_without_torch_the_extra_is_named() -> None:
    program = "import sys; sys.modules['torch'] = None; import sunset; sunset.train_model('lite', 'out')"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "MissingExtraError: Training needs torch, not installed: pip install" in done.stderr
