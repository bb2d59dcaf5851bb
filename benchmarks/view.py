"""How long `sunset view` takes, how large its page is, and how quick that is in the browsers that are installed.

Run from the repository's folder: `python -m benchmarks.view`. Prints the best of several rounds: seconds to run the
default run again and to make its page, the page's bytes, milliseconds to the first picture, and pictures a second while
every frame of the run is gone through, drawn, once.
"""

import argparse
import tempfile
from pathlib import Path
from time import perf_counter

from tests.viewing.browsers import PROGRAMS, program_of, started

import sunset

_FIRST = """
while (!performance.getEntriesByName("first-frame").length) await new Promise(requestAnimationFrame);
return performance.getEntriesByName("first-frame")[0].startTime;
"""
_SCRUB = """
const stage = document.getElementById("stage").dataset;
const scrubber = document.getElementById("scrubber");
const began = performance.now();
let frames = 0;
for (let time = Number(scrubber.min); time < Number(scrubber.max); time += 0.1) {
  scrubber.value = time;
  scrubber.dispatchEvent(new Event("input"));
  while (stage.time !== stage.asked) await new Promise(requestAnimationFrame);
  frames++;
}
return (1000 * frames) / (performance.now() - began);
"""


def main() -> None:
    """Run once, then view several times."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=3, metavar="N")
    rounds = parser.parse_args().rounds
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "page.html"
        sunset.run(out=Path(folder) / "run")
        sunset.run(out=Path(folder) / "images", images=True)
        for name in ("run", "images"):
            seconds = []
            for _ in range(rounds):
                began = perf_counter()
                sunset.view(Path(folder) / name, out=page, show=False)
                seconds.append(perf_counter() - began)
            what = "with images" if name == "images" else "without images, which is run again"
            print(f"page of a record {what}: {min(seconds):.1f} s, {page.stat().st_size} bytes")
        for browser in filter(program_of, PROGRAMS):
            first, rates = [], []
            for _ in range(rounds):
                with started(browser) as opened:
                    opened.open(page.as_uri())
                    first.append(opened.evaluate(_FIRST))
                    rates.append(opened.evaluate(_SCRUB))
            print(f"{browser}: first picture after {min(first):.0f} ms, {max(rates):.0f} pictures/s")


if __name__ == "__main__":
    main()
