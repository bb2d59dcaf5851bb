import os
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from sunset.errors import OutputError
from sunset.evaluation.figures import entropy_figure
from sunset.metrics import Samples


def samples(level: float, start: float = -3.0) -> Samples:
    times = np.arange(round(start * 10), 200) / 10
    return Samples(times, np.full(len(times), level))


SERIES = {"no fault": samples(0.1), "image_shift": samples(0.3)}
IOU = {"no fault": samples(0.5, 0), "image_shift": samples(0.2, 0)}


def test_every_line_is_drawn_in_its_own_colour(tmp_path: Path) -> None:
    file = tmp_path / "new" / "entropy.png"
    entropy_figure(SERIES, 0.2, file, iou=IOU)
    pixels = cv2.imread(str(file))
    assert pixels is not None
    assert pixels.shape == (840, 2100, 3)  # two columns of a paper, 7 by 2.8 inches at 300 dots an inch
    for colour in ((0, 0, 0), (0xB2, 0x72, 0x00)):  # blue, green, red
        assert (pixels == colour).all(axis=2).sum() > 2000  # a legend's has some hundred


def test_the_threshold_is_named_as_it_is(tmp_path: Path) -> None:
    entropy_figure(SERIES, 0.2953, tmp_path / "entropy.svg", iou=IOU)

    assert "threshold 0.295" in (tmp_path / "entropy.svg").read_text(encoding="utf-8")


@pytest.mark.thorough
@pytest.mark.parametrize("suffix", [".pdf", ".svg", ".png"])
def test_the_same_figure_has_the_same_bytes(tmp_path: Path, suffix: str) -> None:
    files = [tmp_path / f"{name}{suffix}" for name in ("a", "b")]
    for file in files:
        entropy_figure(SERIES, 0.2, file, iou=IOU)
    assert files[0].read_bytes() == files[1].read_bytes()


MINE = """
import sys
from pathlib import Path
import numpy as np
from sunset.evaluation.figures import entropy_figure
from sunset.metrics import Samples
times = np.arange(100) / 10
series = {"no fault": Samples(times, np.full(100, 0.1))}
entropy_figure(series, 0.2, Path(sys.argv[1]), iou=series)
"""


@pytest.mark.parametrize(
    "back_end", ["module://of_a_notebook.that_is_not_here", pytest.param("agg", marks=pytest.mark.thorough)]
)
def test_a_users_settings_of_matplotlib_change_no_figure(tmp_path: Path, back_end: str) -> None:
    pytest.importorskip("matplotlib")
    (tmp_path / "matplotlibrc").write_text("text.usetex: True\nlines.linewidth: 9\nsavefig.dpi: 20\n")
    settings = {"MPLBACKEND": back_end, "MATPLOTLIBRC": str(tmp_path)}
    for name, environment in (("plain.png", {}), ("mine.png", settings)):
        command = [sys.executable, "-c", MINE, str(tmp_path / name)]
        subprocess.run(command, env={**os.environ, **environment}, check=True)
    assert (tmp_path / "mine.png").read_bytes() == (tmp_path / "plain.png").read_bytes()


def test_samples_with_gaps_few_or_none_are_drawn(tmp_path: Path) -> None:
    gap = np.concatenate([np.arange(0, 20), np.arange(80, 200)]) / 10
    odd = {
        "gap": Samples(gap, np.full(len(gap), 0.3)),
        "few": Samples(np.array([0.0, 0.1]), np.array([0.1, 0.2])),
        "none": Samples(),
    }
    entropy_figure(odd, 0.2, tmp_path / "odd.svg", iou=odd)
    assert (tmp_path / "odd.svg").stat().st_size > 1000


def test_a_file_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="cannot be written"):
        entropy_figure(SERIES, 0.2, tmp_path / "file" / "x.png", iou=IOU)
