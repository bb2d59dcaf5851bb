import json
from pathlib import Path

import pytest

from sunset.errors import OutputError
from sunset_lab.plots import draw_log

pytest.importorskip("matplotlib")

pytestmark = pytest.mark.thorough

LINES = [
    {"step": 20, "learning_rate": 0.1, "rgb": 3.0, "fusion": 2.0, "misaligned": 3.0, "seconds": 1.0},
    {
        "step": 40,
        "learning_rate": 0.1,
        "rgb": 2.0,
        "fusion": 1.0,
        "misaligned": 2.0,
        "seconds": 2.0,
        "iou": {"rgb": 0.1, "fusion": 0.2},
    },
]


def test_a_log_becomes_a_figure(tmp_path: Path) -> None:
    log, png = tmp_path / "log.jsonl", tmp_path / "log.png"
    log.write_text("".join(f"{json.dumps(line)}\n" for line in LINES), encoding="utf-8")
    draw_log(log, png)
    assert png.read_bytes().startswith(b"\x89PNG")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["log.jsonl", "log.png"]
    with pytest.raises(OutputError, match=r"The figure .* cannot be written: No such file"):
        draw_log(log, tmp_path / "missing" / "log.png")
