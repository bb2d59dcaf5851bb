"""Giving a model that is there its temperatures, thresholds and card, without training."""

import hashlib
import shutil
from collections.abc import Mapping
from dataclasses import asdict, replace
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset import perception
from sunset.calibration import (
    SAMPLES,
    Condition,
    CurvesPlan,
    part_entropy,
    part_sharpness,
    plan_curves,
    window_means,
)
from sunset.classes import CLASS_OF_CARLA_ID
from sunset.data import FlightPlan, flight_bag, read_bag
from sunset.errors import DataError, InvalidInputError, MissingExtraError, ModelError, OutputError
from sunset.perception import Modality, Model, Segmenter, find_device, is_installed, load_model
from sunset.perception.card import check_name
from sunset.processes.workers import Stages
from sunset.system import loaded_extensions
from sunset.training.batches import FrameSet
from sunset.training.calibrate import temperature_for
from sunset.training.curves import Case, Curves, curves_of, look
from sunset.training.frames import COURSES_DEG, VALIDATION_TOWN, FrameCounts
from sunset.training.over_frames import Images, over_frames
from sunset.training.spread import Arrays

TEMPERATURE: Final = "temperature"
"""The name of the constant in a network's graph that the logits are divided by before the entropy."""

_CALIBRATION_FRAMES: Final = 60

Values = npt.NDArray[np.float64]


def frames_of_bag(path: Path, size: tuple[int, int] | None = None) -> FrameSet:
    """Return the frames of a bag, in memory.

    Args:
        path: of the bag.
        size: height and width that frames of another size are resampled to; None: they stay as they are.

    Raises:
        DataError: there is no such bag, or it is unusable.
    """
    with read_bag(path, size=size) as reader:
        frames = [reader.frame(index) for index in range(len(reader))]
    return FrameSet(
        np.stack([frame.rgb for frame in frames]),
        np.stack([frame.depth for frame in frames]),
        CLASS_OF_CARLA_ID[np.stack([frame.labels for frame in frames])],
    )


def validation_flight(
    size: tuple[int, int],
    *,
    count: int = FrameCounts().passage,
    jobs: int | None = None,
    progress: Stages | None = None,
) -> FrameSet:
    """Return the flights over the town that thresholds are chosen on, rendered once and kept in the cache folder.

    Args:
        size: height and width of a frame in pixels.
        count: frames of each of the two flights.
        jobs: processes that render; as many as there are processors, at most 8, if None.
        progress: called while frames are rendered.

    Raises:
        OutputError: the cache folder cannot be written.
    """
    rendering = partial(progress, "Rendering the validation flights (once)") if progress else None
    parts = []
    for course in COURSES_DEG:
        plan = FlightPlan(town=VALIDATION_TOWN, frames=count, course_deg=course, size=size)
        parts.append(frames_of_bag(flight_bag(plan, progress=rendering, jobs=jobs)))
    return FrameSet(
        np.concatenate([part.bgr for part in parts]),
        np.concatenate([part.depth for part in parts]),
        np.concatenate([part.labels for part in parts]),
    )


def calibrate_model(
    model: Model,
    frames: FrameSet,
    out: Path | None = None,
    *,
    source: str = "frames of the caller's",
    jobs: int | None = None,
    device: str = "cpu",
    progress: Stages | None = None,
    kept: Path | None = None,
) -> Model:
    """Give a model its temperatures, its two thresholds, measured results, and a card that says so.

    All networks get the entropy that the main one has on average without a temperature. The thresholds part
    healthy from faulty best. Files are changed when all is measured, so that an interrupted call changes none.

    Args:
        model: of which nothing but the networks is used; a model of the package is not changed.
        frames: consecutive ones, of the model's size, at least five.
        out: a folder that is to be made and receives the calibrated model, which is called as the folder; if None, the
            model's own is changed.
        source: where the frames are from, for the card.
        jobs: processes; as many as there are processors if None. It has no influence on the result.
        device: what the networks run on, as a `Segmenter` takes it.
        progress: called now and then.
        kept: a folder that keeps what was measured, so that an interrupted call loses little; None for nowhere.

    Raises:
        MissingExtraError: onnx is not installed, or what the device needs.
        InvalidInputError: the model is an installed one, and no other folder is given; or there is no such device.
        DataError: the frames are too few or of another size, or nothing can be told from them.
        ModelError: a network has no temperature to set, or logits whose width does not divide the frames'.
        OutputError: a folder cannot be written, or exists.
    """
    check_target(model, out)
    _check_frames(model, frames)
    device = find_device(device)
    target = out or model.folder
    if out is not None:
        model = replace(model, card=replace(model.card, name=out.resolve().name))
    try:
        home = model.folder if out is None else out.parent
        home.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(prefix=".calibrating-", dir=home) as name:
            draft = Path(name) / "model"
            tempered = _tempered(
                _copied(model, draft), device, frames, jobs=jobs, progress=progress, kept=kept
            )
            plan = plan_curves(tempered.card, grid={})
            values = _looks(tempered, device, plan, frames, jobs=jobs, progress=progress, kept=kept)
            _write_card(tempered, plan, values, source)
            _publish(draft, target, whole=out is not None)
    except OSError as error:
        raise OutputError(f"The model {target} cannot be written: {error.strerror or error}.") from error
    return load_model(target)


def check_target(model: Model, out: Path | None) -> None:
    """Find out whether a model can be calibrated into a folder, before frames are looked at.

    Args:
        model: the model.
        out: as `calibrate_model` takes it.

    Raises:
        MissingExtraError: onnx is not installed.
        InvalidInputError: the model is an installed one, and no other folder is given; or the folder's name cannot be a
            model's.
        OutputError: the folder exists.
    """
    if find_spec("onnx") is None:
        raise MissingExtraError(
            "Calibrating needs onnx, which is not installed; run: pip install 'sunset-exemplar[train]'."
        )
    if out is None and is_installed(model.folder):
        raise InvalidInputError(
            f"The model {model.card.name!r} is an installed one and is not changed: name a folder for a calibrated "
            "copy with --out."
        )
    if out is not None:
        check_name(out.resolve().name)
        if out.exists():
            raise OutputError(f"The folder {out} exists: name a new one for the calibrated model.")


def _check_frames(model: Model, frames: FrameSet) -> None:
    size = (model.card.height, model.card.width)
    if frames.bgr.shape[1:3] != size or len(frames) < SAMPLES:
        height, width = frames.bgr.shape[1:3]
        raise DataError(
            f"Calibrating {model.card.name!r} needs at least {SAMPLES} frames of {size[1]}x{size[0]} pixels, got "
            f"{len(frames)} of {width}x{height}."
        )


def _copied(model: Model, draft: Path) -> Model:
    """Return a copy of a model whose networks have no temperature."""
    draft.mkdir()
    for network in model.card.networks.values():
        for file in network.files:
            shutil.copyfile(model.folder / file, draft / file)
    return _with_temperatures(Model(draft, model.card), dict.fromkeys(model.card.networks, 1.0))


def _write_card(model: Model, plan: CurvesPlan, values: Values, source: str) -> None:
    """Write the card of a model that has its temperatures.

    Args:
        model: in a folder of its own.
        plan: whose conditions were measured.
        values: (frames, conditions, 3): IoU, entropy and sharpness.
        source: where the frames are from.
    """
    places = {condition: place for place, condition in enumerate(plan.conditions())}

    def means(column: int, condition: Condition) -> Values:
        return window_means(values[:, places[condition], column], 1)

    entropy, sharpness = part_entropy(plan, partial(means, 1)), part_sharpness(plan, partial(means, 2))
    card = replace(model.card, entropy_threshold=entropy.threshold, sharpness_threshold=sharpness.threshold)
    curves = curves_of(plan, card, values, partial(window_means, every=1))
    limits = {"entropy": _rounded(asdict(entropy)), "sharpness": _rounded(asdict(sharpness))}
    results: dict[str, object] = {"measured_on": f"{len(values)} frames: {source}", **_results(curves)}
    results["thresholds"] = limits
    replace(card, results={**card.results, **results}).write(
        model.folder
    )  # what else was measured still holds


def _tempered(
    model: Model,
    device: str,
    frames: FrameSet,
    *,
    jobs: int | None,
    progress: Stages | None,
    kept: Path | None,
) -> Model:
    """Give every network the mean entropy that the main one has without a temperature; return the model then."""
    main, *others = sorted(model.card.networks)
    chosen = np.linspace(0, len(frames) - 1, min(_CALIBRATION_FRAMES, len(frames))).astype(int)
    entropies, *logits = over_frames(
        _entropy_and_logits,
        (main, tuple(others)),
        model,
        FrameSet(frames.bgr[chosen], frames.depth[chosen], frames.labels[chosen]),
        device=device,
        jobs=jobs,
        progress=partial(progress, "Temperatures") if progress else None,
        kept=kept,
    )
    target = float(np.mean(entropies))
    found = {main: 1.0}
    for modality, maps in zip(others, logits, strict=True):
        found[modality] = temperature_for(list(maps), target, model.card.width)
    return _with_temperatures(model, found)


def _entropy_and_logits(
    segmenter: Segmenter, _: int, images: Images, main: Modality, others: tuple[Modality, ...]
) -> Arrays:
    """Return the entropy that the main network has for a frame, and the logits of the others."""
    bgr, depth = images[:2]
    entropy = segmenter.segment(main, bgr, depth).entropy
    return np.array(entropy), *(segmenter.logits(modality, bgr, depth) for modality in others)


def _looks(
    model: Model,
    device: str,
    plan: CurvesPlan,
    frames: FrameSet,
    *,
    jobs: int | None,
    progress: Stages | None,
    kept: Path | None,
) -> Values:
    """Return IoU, entropy and sharpness of every frame in every condition (frames, conditions, 3)."""
    measuring = partial(progress, "Measuring") if progress else None
    (found,) = over_frames(
        look,
        (plan.conditions(), loaded_extensions()),
        model,
        frames,
        device=device,
        jobs=jobs,
        progress=measuring,
        kept=kept,
    )
    return found


def _results(curves: Curves) -> dict[str, object]:
    """Return the card's tables."""
    faults: dict[str, object] = {
        f"nominal, {network.key}": {"strength": "", **_rounded(asdict(figures))}
        for network, figures in curves.nominal.items()
    }
    for case in curves.points:
        faults[case.name] = _row(case) | _rounded(asdict(case.before))
        if case.after is not None:
            faults[f"{case.name}, cured"] = _row(case) | _rounded(asdict(case.after))
    pairs = {case.name: _rounded(asdict(case.before)) for case in curves.pairs}
    return {"faults_at_suite_strength": faults, "pairs_of_faults_at_suite_strength": pairs}


def _row(case: Case) -> dict[str, object]:
    return {"strength": next(iter(case.strengths.values()))}


def _rounded(values: Mapping[str, float]) -> dict[str, object]:
    return {name: round(value, 4) for name, value in values.items()}


def _with_temperatures(model: Model, temperatures: Mapping[Modality, float]) -> Model:
    """Set the temperatures of a model's networks, write its card, and return it as it is then."""
    networks = {}
    for modality, network in sorted(model.card.networks.items()):
        path = model.folder / network.file
        set_temperature(path, temperatures[modality])
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        networks[modality] = replace(network, sha256=digest, temperature=temperatures[modality])
    card = replace(model.card, version=version_of(networks), networks=networks, entropy_threshold=1.0)
    card.write(model.folder)
    return load_model(model.folder)


def version_of(networks: Mapping[Modality, perception.NetworkCard]) -> str:
    """Return the version of a model: a checksum of its networks."""
    return hashlib.sha256("".join(network.digest for network in networks.values()).encode()).hexdigest()[:12]


def set_temperature(path: Path, temperature: float) -> None:
    """Write another temperature into a network's file; files that hold its weights beside it are not touched.

    Args:
        path: of the ONNX file.
        temperature: greater than 0.

    Raises:
        ModelError: the file is no network, or has no constant of the name.
    """
    from onnx import numpy_helper  # noqa: PLC0415  an optional dependency

    from sunset.training.onnx_reader import read_network  # noqa: PLC0415  needs it

    network = read_network(path, weights=False)
    for constant in network.graph.initializer:
        if constant.name == TEMPERATURE:
            value = np.full(tuple(constant.dims), temperature, dtype=np.float32)
            constant.CopyFrom(numpy_helper.from_array(value, TEMPERATURE))
            path.write_bytes(network.SerializeToString(deterministic=True))
            return
    raise ModelError(
        f"The network {path} has no constant {TEMPERATURE!r} that its logits are divided by; export or import it "
        "with this version."
    )


def _publish(draft: Path, target: Path, *, whole: bool) -> None:
    """Put finished files in their place: a new folder, or one file after the other, the card last."""
    if whole:
        draft.rename(target)
        return
    for path in sorted(draft.iterdir(), key=lambda path: path.name.startswith("card")):
        path.replace(target / path.name)
