"""How long the gallery's managing systems take to import, to start, and to decide.

Run it with `python benchmarks/gallery.py` where examples/gallery/requirements.txt is installed. Each is measured in a
process of its own, without walls; the decision is the first while the segmentation is unsure.
"""

import re
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path

from sunset.managing import Symptoms, load_manager
from sunset.system.vocabulary import current_system, frequency_entry
from sunset.texts.tables import aligned
from sunset_ros.testing import World

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "examples" / "gallery" / "README.md"


def measure(spec: str) -> None:
    """Print the seconds of import, start and decision of a managing system."""
    moments = [time.perf_counter()]
    manager_class = load_manager(spec, ROOT)
    moments.append(time.perf_counter())
    manager = World().start(manager_class)
    moments.append(time.perf_counter())
    healthy = {frequency_entry(topic): 10.0 for topic in current_system().topics}
    manager.adapt(Symptoms({**healthy, "segmentation_entropy": 0.9}))
    moments.append(time.perf_counter())
    print(*(f"{after - before:.3f}" for before, after in pairwise(moments)))


def main() -> None:
    """Measure all classes of the gallery, or the class that is named."""
    if sys.argv[1:]:
        measure(sys.argv[1])
        return
    lines = [["managing system", "import [s]", "start [s]", "decision [s]"]]
    for spec in dict.fromkeys(re.findall(r"--manager (examples/\S+?:\w+)", PAGE.read_text(encoding="utf-8"))):
        words = [sys.executable, __file__, spec]
        printed = subprocess.check_output(words, text=True, cwd=ROOT)  # noqa: S603  this file
        lines.append([spec.rpartition(":")[2], *printed.split()])
    print("\n".join(aligned(lines, (0,))))


if __name__ == "__main__":
    main()
