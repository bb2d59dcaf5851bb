"""Calibration of a model without training: temperatures, thresholds, results and card."""

import hashlib
import shutil
from collections.abc import Mapping
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final, Unpack

import numpy as np
import numpy.typing as npt
import onnx
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
from sunset.calibration.thresholds import Separation
from sunset.errors import DataError, InvalidInputError, ModelError, OutputError
from sunset.files.inputs import file_digest
from sunset.metrics import normalised_entropy
from sunset.perception import Modality, Model, NetworkCard, Segmenter, is_installed, load_model
from sunset.perception.card import check_name
from sunset.processes.workers import Stages
from sunset.system import loaded_extensions
from sunset_lab.architecture import upsampling
from sunset_lab.curves import Curves, Figures, curves_of, look
from sunset_lab.frames import FrameSet, Images, titled
from sunset_lab.measuring import Arrays, LookOptions, over_frames

TEMPERATURE: Final = "temperature"
"""The constant in a network's graph by which the logits are divided for the entropy."""

_TEMPERATURES: Final = (0.05, 20.0)
_FRAMES: Final = 60
"""At most so many frames determine the temperatures."""
_EVERY: Final = 3
"""Every third row and column does; odd, so that pixels near to and far from a logit take part."""


def calibrate_model(
    model: Model,
    frames: FrameSet,
    out: Path | None = None,
    *,
    source: str = "frames of the caller's",
    stages: Stages | None = None,
    **options: Unpack[LookOptions],
) -> Model:
    """Calibrate a model, or a copy in the new folder `out`, which is named after it; the rest is as in `calibrate`.

    Files change after the last measurement, so an interrupted call changes none.
    """
    check_target(model, out)
    target, home = (model.folder, model.folder) if out is None else (out, out.parent)
    card = model.card if out is None else replace(model.card, name=out.resolve().name)
    try:
        home.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(prefix=".calibrating-", dir=home) as name:
            draft = Path(name)
            for file in {file for network in card.networks.values() for file in network.files}:
                shutil.copyfile(model.folder / file, draft / file)
            calibrate(Model(draft, card), frames, source, stages, **options)
            publish(draft, target)
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


def publish(draft: Path, target: Path) -> None:
    """Copy a model's finished files into a folder, the card last; each appears there complete."""
    target.mkdir(parents=True, exist_ok=True)
    paths = sorted(draft.iterdir(), key=lambda path: path.name.startswith("card"))
    for copy in [Path(shutil.copyfile(path, target / f"{path.name}.tmp")) for path in paths]:
        copy.replace(copy.with_suffix(""))


def calibrate(
    model: Model,
    frames: FrameSet,
    source: str,
    stages: Stages | None = None,
    **options: Unpack[LookOptions],
) -> Model:
    """Give a model temperatures, thresholds, measured results, and a card with them, in its own folder.

    All networks get the mean entropy that the main network has without a temperature. The frames, at least five of the
    model's size, are consecutive, and the card names `source` as their origin.
    """
    size, given = (model.card.height, model.card.width), frames.bgr.shape[1:3]
    if given != size or len(frames) < SAMPLES:
        raise DataError(
            f"Calibrating {model.card.name!r} needs at least {SAMPLES} frames of {size[1]}x{size[0]} pixels, got "
            f"{len(frames)} of {given[1]}x{given[0]}."
        )
    model = _with_temperatures(model, dict.fromkeys(model.card.networks, 1.0))
    main, *others = sorted(model.card.networks)
    options["progress"] = titled(stages, "Temperatures")
    entropies, *logits = over_frames(
        _entropy_and_logits, (main, tuple(others)), model, frames.spread_out(_FRAMES), **options
    )
    target = float(np.mean(entropies))
    fitted = [temperature_for(list(maps), target, model.card.width) for maps in logits]
    model = _with_temperatures(model, {main: 1.0, **dict(zip(others, fitted, strict=True))})
    plan = plan_curves(model.card, grid={})
    options["progress"] = titled(stages, "Measuring")
    (values,) = over_frames(look, (plan.conditions(), loaded_extensions()), model, frames, **options)
    _write_card(model, plan, values, source)
    return load_model(model.folder)


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
    height, low_width = logits[0].shape[1:]
    rows, columns = (upsampling(size, width // low_width)[::_EVERY] for size in (height, low_width))
    full = [np.einsum("ih,chw,jw->cij", rows, low, columns, optimize=True) for low in logits]

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


def _with_temperatures(model: Model, temperatures: Mapping[Modality, float]) -> Model:
    """Write temperatures into a model's networks and its card, and load it again."""
    networks = {}
    for modality, network in sorted(model.card.networks.items()):
        path = model.folder / network.file
        set_temperature(path, temperatures[modality])
        networks[modality] = replace(network, sha256=file_digest(path), temperature=temperatures[modality])
    card = replace(model.card, version=version_of(networks), networks=networks, entropy_threshold=1.0)
    card.write(model.folder)
    return load_model(model.folder)


def version_of(networks: Mapping[Modality, NetworkCard]) -> str:
    """Return a model's version: a checksum of its networks."""
    return hashlib.sha256("".join(network.digest for network in networks.values()).encode()).hexdigest()[:12]


def set_temperature(path: Path, temperature: float) -> None:
    """Write a temperature, greater than 0, into the ONNX file of a network."""
    network = onnx.load(path, load_external_data=False)
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
        "thresholds": {"entropy": _rounded(entropy), "sharpness": _rounded(sharpness)},
    }
    # other results on the card are still valid
    replace(card, results={**card.results, **results}).write(model.folder)


def _results(curves: Curves) -> dict[str, object]:
    """Return the card's tables."""
    rows: dict[str, object] = {
        f"nominal, {network.key}": {"strength": "", **_rounded(figures)}
        for network, figures in curves.nominal.items()
    }
    for case in curves.points:
        (strength,) = case.strengths.values()
        rows[case.name] = {"strength": strength, **_rounded(case.before)}
        if case.after is not None:
            rows[f"{case.name}, cured"] = {"strength": strength, **_rounded(case.after)}
    pairs = {case.name: _rounded(case.before) for case in curves.pairs}
    return {"faults_at_suite_strength": rows, "pairs_of_faults_at_suite_strength": pairs}


def _rounded(values: Figures | Separation) -> dict[str, float]:
    return {name: round(value, 4) for name, value in asdict(values).items()}
