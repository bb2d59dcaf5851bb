"""The list of models: their size, their IoU, and how fast they are on this computer."""

from collections.abc import Mapping
from dataclasses import dataclass
from time import perf_counter
from typing import Final

from sunset.errors import ModelError
from sunset.perception import OFFERED, Modality, Segmenter, list_models, load_model

_FRAMES: Final = 4
"""How many frames are segmented to measure the time for a frame; the quickest counts."""


@dataclass(frozen=True)
class ListedModel:
    """An installed model; the IoU is None if the training that wrote its card did not measure it."""

    name: str
    width: int
    height: int
    parameters: int
    bytes: int
    iou: float | None
    frame_ms: float


def survey_models(device: str = "cpu") -> tuple[list[ListedModel], dict[str, str], list[str]]:
    """Return the installed models, with the time that each takes for a frame on a device, measured now.

    Also return the commands that install others, and the reasons why some cannot be loaded.
    """
    models, complaints = [], []
    for name in list_models():
        try:
            models.append(_listed(name, device))
        except ModelError as error:  # maybe of another distribution, whose model is broken
            complaints.append(str(error))
    return models, {name: OFFERED[name] for name in OFFERED if name not in list_models()}, complaints


def _listed(name: str, device: str) -> ListedModel:
    model = load_model(name)
    card, modality = model.card, min(model.card.networks)
    files = {file for network in card.networks.values() for file in network.files}
    segmenter = Segmenter(model, device=device)
    times = []
    for _ in range(_FRAMES):
        begun = perf_counter()
        segmenter.warm_up(modality)
        times.append(perf_counter() - begun)
    return ListedModel(
        name=name,
        width=card.width,
        height=card.height,
        parameters=card.networks[modality].parameters,
        bytes=sum((model.folder / file).stat().st_size for file in files),
        iou=_test_iou(card.results, modality),
        frame_ms=min(times) * 1e3,
    )


def _test_iou(results: Mapping[str, object], modality: Modality) -> float | None:
    """Return the IoU on the town that was kept for the test, if the card has it."""
    value: object = results
    for key in ("iou_per_image", "test town", modality.key):
        value = value.get(key) if isinstance(value, Mapping) else None
    return float(value) if isinstance(value, int | float) else None
