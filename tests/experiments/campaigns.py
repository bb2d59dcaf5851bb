"""A short campaign that several tests disturb, each in its way."""

import sys
from pathlib import Path

RUNS = 12

SHORT_WARM_UP = "17"
"""A seed that draws a warm-up that is about as short as can be."""


def bench_command(out: Path, *options: str) -> list[str]:
    """Return the command of a campaign of twelve short runs."""
    command = [sys.executable, "-m", "sunset", "bench", "--suite", "degraded", "--managers", "baseline"]
    command += ["--scenarios", "image_degradation+image_shift,depth_degradation+autofocus_needed"]
    return [
        *command,
        "--duration",
        "1",
        "--repetitions",
        "1",
        "--seed",
        SHORT_WARM_UP,
        "--no-score",
        *options,
        "--out",
        str(out),
    ]


def content_of(folder: Path) -> dict[str, bytes]:
    """Return the content of each file in a folder, but of those that tell who works in it."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and not path.name.startswith(".lock")
    }
