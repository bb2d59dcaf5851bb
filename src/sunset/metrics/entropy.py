"""The uncertainty of a network."""

import numpy as np
import numpy.typing as npt


def normalised_entropy(logits: npt.NDArray[np.floating], *, temperature: float = 1.0) -> float:
    """Return the mean over pixels of the Shannon entropy of the softmax, divided by its maximum.

    The paper (section 3.3) uses the mean entropy of the logits. Divided by the logarithm of the number of classes, it
    is 0 if the network is sure everywhere, and 1 if all classes are equally likely.

    Args:
        logits: (C, H, W), finite, at least two classes C and one pixel.
        temperature: the logits are divided by it; greater than 0.

    Raises:
        ValueError: the shape or the temperature is invalid.

    >>> normalised_entropy(np.zeros((28, 2, 3)))
    1.0
    """
    if logits.ndim != 3 or logits.shape[0] < 2 or logits.size == 0:  # noqa: PLR2004  shape (C >= 2, H, W)
        raise ValueError(f"Logits must have shape (C, H, W) with C of 2 or more, got {logits.shape}.")
    if not temperature > 0:
        raise ValueError(f"The temperature must be greater than 0, got {temperature!r}.")
    scaled = logits.astype(np.float64) / temperature
    scaled -= scaled.max(axis=0)
    weights = np.exp(scaled)
    total = weights.sum(axis=0)
    entropy = np.log(total) - (weights * scaled).sum(axis=0) / total
    return float(np.clip(entropy.mean() / np.log(len(logits)), 0.0, 1.0))
