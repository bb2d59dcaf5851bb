"""Calibration of a model without training: temperatures, thresholds, results and card."""

import hashlib
import shutil
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt
from onnx import numpy_helper

from sunset.calibration import (
    SAMPLES,
    Condition,
    CurvesPlan,
    Values,
    part_entropy,
    part_sharpness,
    plan_curves,
    window_means,
)
from sunset.errors import DataError, InvalidInputError, ModelError, OutputError
from sunset.metrics import normalised_entropy
from sunset.perception import Modality, Model, NetworkCard, Segmenter, find_device, is_installed, load_model
from sunset.perception.card import check_name
from sunset.processes.workers import Stages
from sunset.system import loaded_extensions
from sunset_lab.batches import FrameSet, Images
from sunset_lab.curves import Case, Curves, curves_of, look
from sunset_lab.inputs import upsampling
from sunset_lab.onnx_reader import read_network
from sunset_lab.over_frames import Arrays, LookOptions, over_frames

TEMPERATURE: Final = "temperature"
"""The constant in a network's graph by which the logits are divided for the entropy."""

_TEMPERATURES: Final = (0.05, 20.0)
_FRAMES: Final = 60
"""At most so many frames determine the temperatures."""
_EVERY: Final = 3
"""Every third row and column does; odd, so that pixels near to and far from a logit take part."""


class _Looking(NamedTuple):
    """The frames, a progress with titles, and the other options of `over_frames`."""

    frames: FrameSet
    progress: Stages | None
    options: LookOptions

    def over(
        self, title: str, look: Callable[..., Arrays], arguments: tuple[object, ...], model: Model
    ) -> Arrays:
        """Look at all frames; as `over_frames`."""
        progress = partial(self.progress, title) if self.progress else None
        options: LookOptions = {**self.options, "progress": progress}
        return over_frames(look, arguments, model, self.frames, **options)


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
    """Give a model temperatures, thresholds, measured results, and a card with them.

    All networks get the mean entropy that the main network has without a temperature. Files change after the last
    measurement, so an interrupted call changes none.

    Args:
        model: only its networks are used.
        frames: consecutive, of the model's size, at least five.
        out: a new folder for the calibrated model, and its name; None to change the model itself.
        source: the origin of the frames, for the card.
        jobs: see `LookOptions`.
        device: likewise.
        progress: called with a title, frames done and frames in all.
        kept: see `LookOptions`.
    """
    check_target(model, out)
    _check_frames(model, frames)
    looking = _Looking(frames, progress, {"device": find_device(device), "jobs": jobs, "kept": kept})
    target, home = (model.folder, model.folder) if out is None else (out, out.parent)
    card = model.card if out is None else replace(model.card, name=out.resolve().name)
    try:
        home.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(prefix=".calibrating-", dir=home) as name:
            draft = Path(name) / "model"
            _write_calibrated(_copied(replace(model, card=card), draft), looking, source)
            _publish(draft, target, whole=out is not None)
    except OSError as error:
        raise OutputError(f"The model {target} cannot be written: {error.strerror or error}.") from error
    return load_model(target)


def check_target(model: Model, out: Path | None) -> None:
    """Refuse to change an installed model, and to replace a folder."""
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
    """Return a copy of a model without temperatures."""
    draft.mkdir()
    for network in model.card.networks.values():
        for file in network.files:
            shutil.copyfile(model.folder / file, draft / file)
    return _with_temperatures(Model(draft, model.card), dict.fromkeys(model.card.networks, 1.0))


def _publish(draft: Path, target: Path, *, whole: bool) -> None:
    """Move finished files to a new folder, or replace those of a model, the card last."""
    if whole:
        draft.rename(target)
        return
    for path in sorted(draft.iterdir(), key=lambda path: path.name.startswith("card")):
        path.replace(target / path.name)


def _write_calibrated(model: Model, looking: _Looking, source: str) -> None:
    """Calibrate a model in its own folder."""
    model = _with_temperatures(model, _temperatures(model, looking))
    plan = plan_curves(model.card, grid={})
    (values,) = looking.over("Measuring", look, (plan.conditions(), loaded_extensions()), model)
    _write_card(model, plan, values, source)


def _temperatures(model: Model, looking: _Looking) -> dict[Modality, float]:
    """Return temperatures with which all networks have the main network's mean entropy."""
    frames = looking.frames
    main, *others = sorted(model.card.networks)
    chosen = np.linspace(0, len(frames) - 1, min(_FRAMES, len(frames))).astype(int)
    few = FrameSet(frames.bgr[chosen], frames.depth[chosen], frames.labels[chosen])
    entropies, *logits = looking._replace(frames=few).over(
        "Temperatures", _entropy_and_logits, (main, tuple(others)), model
    )
    target = float(np.mean(entropies))
    fitted = [temperature_for(list(maps), target, model.card.width) for maps in logits]
    return {main: 1.0, **dict(zip(others, fitted, strict=True))}


def _entropy_and_logits(
    segmenter: Segmenter, _: int, images: Images, main: Modality, others: tuple[Modality, ...]
) -> Arrays:
    """Return the main network's entropy for a frame, and the logits of the other networks."""
    bgr, depth = images[:2]
    entropy = segmenter.segment(main, bgr, depth).entropy
    return np.array(entropy), *(segmenter.logits(modality, bgr, depth) for modality in others)


def temperature_for(logits: list[npt.NDArray[np.float32]], entropy: float, width: int) -> float:
    """Return the temperature, to four digits, at which the mean normalised entropy of frames is as given.

    Logits are (28, h, w) for each frame; they are interpolated to `width` in pixels, a multiple of w.
    """
    full = [_sampled(frame, width) for frame in logits]

    def mean_entropy(temperature: float) -> float:
        return float(np.mean([normalised_entropy(frame, temperature=temperature) for frame in full]))

    low, high = _TEMPERATURES
    if not mean_entropy(low) < entropy < mean_entropy(high):
        raise DataError(
            f"No temperature from {low} to {high} gives the networks a mean entropy of {entropy:.4f}."
        )
    for _ in range(24):  # entropy rises with temperature
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if mean_entropy(middle) < entropy else (low, middle)
    return round(float(np.sqrt(low * high)), 4)


def _sampled(low: npt.NDArray[np.float32], width: int) -> npt.NDArray[np.float32]:
    """Return every third row and column of logits (28, h, w) interpolated to a width."""
    factor, rest = divmod(width, low.shape[2])
    if rest:
        raise ModelError(
            f"The width of a network's logits must divide that of its frames, {width}, got {low.shape[2]}: export "
            "or import it with this version."
        )
    rows = upsampling(low.shape[1], factor)[::_EVERY]
    columns = upsampling(low.shape[2], factor)[::_EVERY]
    full: npt.NDArray[np.float32] = np.einsum("ih,chw,jw->cij", rows, low, columns, optimize=True)
    return full


def _with_temperatures(model: Model, temperatures: Mapping[Modality, float]) -> Model:
    """Write temperatures into a model's networks and its card, and load it again."""
    networks = {}
    for modality, network in sorted(model.card.networks.items()):
        path = model.folder / network.file
        set_temperature(path, temperatures[modality])
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        networks[modality] = replace(network, sha256=digest, temperature=temperatures[modality])
    card = replace(model.card, version=version_of(networks), networks=networks, entropy_threshold=1.0)
    card.write(model.folder)
    return load_model(model.folder)


def version_of(networks: Mapping[Modality, NetworkCard]) -> str:
    """Return a model's version: a checksum of its networks."""
    return hashlib.sha256("".join(network.digest for network in networks.values()).encode()).hexdigest()[:12]


def set_temperature(path: Path, temperature: float) -> None:
    """Write a temperature, greater than 0, into the ONNX file of a network."""
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


def _write_card(model: Model, plan: CurvesPlan, values: Values, source: str) -> None:
    """Write a model's card from the values (frames, conditions, 3) of `look`."""
    places = {condition: place for place, condition in enumerate(plan.conditions())}

    def means(column: int, condition: Condition) -> Values:
        return window_means(values[:, places[condition], column], 1)

    entropy, sharpness = part_entropy(plan, partial(means, 1)), part_sharpness(plan, partial(means, 2))
    card = replace(model.card, entropy_threshold=entropy.threshold, sharpness_threshold=sharpness.threshold)
    curves = curves_of(plan, card, values)
    results: dict[str, object] = {
        "measured_on": f"{len(values)} frames: {source}",
        **_results(curves),
        "thresholds": {"entropy": _rounded(asdict(entropy)), "sharpness": _rounded(asdict(sharpness))},
    }
    # other results on the card are still valid
    replace(card, results={**card.results, **results}).write(model.folder)


def _results(curves: Curves) -> dict[str, object]:
    """Return the card's tables."""
    faults: dict[str, object] = {
        f"nominal, {network.key}": {"strength": "", **_rounded(asdict(figures))}
        for network, figures in curves.nominal.items()
    }
    for case in curves.points:
        faults[case.name] = _strength(case) | _rounded(asdict(case.before))
        if case.after is not None:
            faults[f"{case.name}, cured"] = _strength(case) | _rounded(asdict(case.after))
    pairs = {case.name: _rounded(asdict(case.before)) for case in curves.pairs}
    return {"faults_at_suite_strength": faults, "pairs_of_faults_at_suite_strength": pairs}


def _strength(case: Case) -> dict[str, object]:
    return {"strength": next(iter(case.strengths.values()))}


def _rounded(values: Mapping[str, float]) -> dict[str, object]:
    return {name: round(value, 4) for name, value in values.items()}
