import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from sunset.perception import Model, load_model

Frame = tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint16]]


@pytest.fixture(scope="session")
def lite() -> Model:
    return load_model("lite")


@pytest.fixture(scope="session")
def frame() -> Frame:
    """A colour image and a depth image of smooth shapes."""
    y, x = np.mgrid[0:144, 0:256].astype(float)
    channels = [120 + 90 * np.sin(x / (17 + 9 * k)) * np.cos(y / (23 - 5 * k)) for k in range(3)]
    bgr = np.stack(channels, axis=-1).astype(np.uint8)
    depth = (3000 + 8 * (144 - y) + 200 * (np.sin(x / 30) > 0.5)).astype(np.uint16)
    return bgr, depth


@pytest.fixture
def copied(tmp_path: Path, lite: Model) -> Path:
    """A copy of the model's folder that may be damaged."""
    return Path(shutil.copytree(lite.folder, tmp_path / "copied"))


@pytest.fixture
def edit_card(copied: Path) -> Callable[..., Path]:
    """Change fields of the copy's card; returns its folder."""

    def edit(**fields: object) -> Path:
        path = copied / "card.json"
        raw = json.loads(path.read_text(encoding="utf-8"))
        path.write_text(json.dumps(raw | fields), encoding="utf-8")
        return copied

    return edit
