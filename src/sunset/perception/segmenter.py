"""Segmentation of frames with a model's networks."""

from dataclasses import dataclass
from struct import Struct
from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt
import onnxruntime

from sunset.errors import ModelError
from sunset.files.compression import zstd
from sunset.images import ImageCache, LazyImage, key_of, platform_features
from sunset.perception.card import Modality
from sunset.perception.model import RUNTIME_ERRORS, Model, find_device, one_line

_ROUNDING: Final = 1e-3
"""Tolerance of an entropy's range [0, 1], since a network sums in float32."""

_ENTROPY: Final = Struct("<d")
"""An entropy, before the labels of its frame."""

_Colours: TypeAlias = npt.NDArray[np.uint8] | None
_Depths: TypeAlias = npt.NDArray[np.uint16] | None
_Inputs: TypeAlias = dict[str, npt.NDArray[np.generic]]


@dataclass(frozen=True, slots=True, eq=False)
class Segmentation:
    """A network's result for a frame.

    Attributes:
        labels: (H, W) uint8, class indices 0 to 27; read-only.
        entropy: mean over pixels of the Shannon entropy of the softmax, over log 28: 0 sure, 1 uniform.
    """

    labels: npt.NDArray[np.uint8]
    entropy: float

    def __repr__(self) -> str:
        return f"Segmentation({self.labels.shape[1]}x{self.labels.shape[0]}, entropy={self.entropy:.4f})"


class Segmenter:
    """Segments frames with the networks of a model.

    On the processor, a single thread infers, so the result for a frame depends neither on earlier frames, nor on the
    number of cores or the computer's load. Processors with other instructions may give other last bits.

    Args:
        model: the model.
        device: "cpu"; "cuda", with the package onnxruntime-gpu (this project has not tried it on a graphics
            card); or "auto", which is "cuda" where it is offered, else "cpu". With "cuda" bits may differ.
        cache: stores results, or None. It is used with the device "cpu" only, whose results must not mix with others.

    Raises:
        InvalidInputError: the device is unknown.
        MissingExtraError: the device needs a package that is not installed.
    """

    def __init__(self, model: Model, *, device: str = "cpu", cache: ImageCache | None = None) -> None:
        self.model: Final = model
        """The model."""
        self.device: Final = find_device(device)
        """The device of the networks: "cpu" or "cuda"."""
        self._cache = cache if self.device == "cpu" else None

    def __repr__(self) -> str:
        return f"Segmenter({self.model!r}, device={self.device!r}, cache={self._cache!r})"

    def segment(self, modality: Modality, bgr: _Colours, depth: _Depths) -> Segmentation:
        """Segment a frame.

        Args:
            modality: of the network; inputs that it does not need are ignored and may be None.
            bgr: (H, W, 3) uint8, the model's size.
            depth: (H, W) uint16, the model's size; 65535 counts are 1000 m.

        Raises:
            ModelError: an input is missing or of another shape or type, the model lacks the network, or
                the network fails or gives an invalid entropy.
            DataError: the cache is damaged.
            OutputError: the cache cannot be written.
        """
        inputs = self._inputs(modality, bgr, depth)
        if self._cache is None:
            return self._infer(modality, inputs)
        images = (LazyImage.of(inputs[name]) if name in inputs else None for name in ("bgr", "depth"))
        labels, entropy = self.look_up(modality, *images)
        return Segmentation(labels.pixels, entropy)

    def look_up(
        self, modality: Modality, bgr: LazyImage | None, depth: LazyImage | None
    ) -> tuple[LazyImage, float]:
        """Return the labels and the entropy of a frame, as `segment`, without computing what the cache has."""
        card = self.model.card
        if self._cache is None:
            result = self._infer_images(modality, bgr, depth)
            return LazyImage.of(result.labels), result.entropy

        def inferred() -> bytes:
            result = self._infer_images(modality, bgr, depth)
            return _ENTROPY.pack(result.entropy) + zstd.compress(result.labels.tobytes())

        key = self._key(modality, bgr, depth)
        known = self._cache.look_up(key, inferred)
        packed, size = known[_ENTROPY.size :], (card.height, card.width)
        labels = LazyImage(
            size,
            lambda: np.frombuffer(zstd.decompress(packed), np.uint8).reshape(size),
            name=lambda: key,
            cache=self._cache,
        )
        return labels, _ENTROPY.unpack_from(known)[0]

    def _key(self, modality: Modality, bgr: LazyImage | None, depth: LazyImage | None) -> bytes:
        """Return what names an inference: weights, runtime, processor and inputs."""
        network = self.model.card.networks.get(modality)
        needed = (bgr if modality.needs_rgb else None, depth if modality.needs_depth else None)
        inputs = [None if image is None else image.digest for image in needed]
        weights = network and network.digest
        return key_of(platform_features(), onnxruntime.__version__, weights, modality.key, inputs)

    def _infer_images(
        self, modality: Modality, bgr: LazyImage | None, depth: LazyImage | None
    ) -> Segmentation:
        rgb, depths = (None if image is None else image.pixels for image in (bgr, depth))
        return self._infer(modality, self._inputs(modality, rgb, depths))

    def warm_up(self, modality: Modality) -> None:
        """Run a network on an empty image, past the cache, since the first run takes several times as long.

        Raises:
            ModelError: the model lacks the network, or it fails or gives an invalid entropy.
        """
        size = (self.model.card.height, self.model.card.width)
        bgr, depth = np.zeros((*size, 3), np.uint8), np.zeros(size, np.uint16)
        self._infer(modality, self._inputs(modality, bgr, depth))

    def logits(self, modality: Modality, bgr: _Colours, depth: _Depths) -> npt.NDArray[np.float32]:
        """Return the network's logits (28, h, w) before interpolation and temperature.

        Raises:
            ModelError: as `segment`.
        """
        (logits,) = self._run(modality, ["logits"], self._inputs(modality, bgr, depth))
        result: npt.NDArray[np.float32] = logits[0]
        return result

    def _inputs(self, modality: Modality, bgr: _Colours, depth: _Depths) -> _Inputs:
        card = self.model.card
        inputs: _Inputs = {}
        if modality.needs_rgb:
            inputs["bgr"] = _checked("colour image", bgr, (card.height, card.width, 3), np.dtype(np.uint8))
        if modality.needs_depth:
            inputs["depth"] = _checked("depth image", depth, (card.height, card.width), np.dtype(np.uint16))
        return inputs

    def _infer(self, modality: Modality, inputs: _Inputs) -> Segmentation:
        labels, entropy = self._run(modality, ["labels", "entropy"], inputs)
        value = float(entropy.item())
        if not -_ROUNDING <= value <= 1 + _ROUNDING:
            raise ModelError(
                f"The network {modality.key!r} of {self.model!r} must give an entropy from 0 to 1, got {value:g}."
            )
        labels.flags.writeable = False
        return Segmentation(labels.view(np.uint8), value)

    def _run(self, modality: Modality, outputs: list[str], inputs: _Inputs) -> list[npt.NDArray[np.generic]]:
        session = self.model.session(modality, device=self.device)
        try:
            results: list[npt.NDArray[np.generic]] = session.run(outputs, inputs)
        except RUNTIME_ERRORS as error:
            raise ModelError(
                f"The network {modality.key!r} of {self.model!r} failed: {one_line(error)}."
            ) from error
        return results


def _checked(
    name: str, array: npt.NDArray[np.generic] | None, shape: tuple[int, ...], dtype: np.dtype[np.generic]
) -> npt.NDArray[np.generic]:
    if array is None:
        raise ModelError(f"The network needs a {name} of shape {shape} and type {dtype}, got none.")
    if array.shape != shape or array.dtype != dtype:
        raise ModelError(
            f"The network takes a {name} of shape {shape} and type {dtype}, got shape {array.shape} and type "
            f"{array.dtype}."
        )
    return np.ascontiguousarray(array)
