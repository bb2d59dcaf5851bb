"""The page docs/faults.md, made of the catalogue."""

from collections.abc import Iterator
from typing import Final

from sunset.system import Fault, current_system

_HEAD: Final = """\
# The faults

Eleven faults lead to five failures. This page shows each fault and its cures. `scripts/draw_pictures` drew the pictures
and wrote this page; `sunset faults show NAME --figure FILE` draws a single picture.

In a picture of frames, the upper row shows the network's input and the lower row its output. *IoU* measures how correct
the output is, *entropy* how unsure the network is. In a picture over time, each line is a message and each bar a
silence. Orange lines are the edges of the depth image.
"""


def faults_page() -> str:
    """Return the page: a section for each failure, and in it the faults that show as it."""
    return "\n".join((_HEAD, *_sections())).rstrip("\n") + "\n"


def _sections() -> Iterator[str]:
    for failure in current_system().failures.values():
        yield f"## {failure.name}: {failure.description}\n"
        yield f"Symptom: {failure.symptom}.\n"
        for fault in current_system().faults.values():
            if fault.failure == failure.name:
                yield from _fault(fault)


def _fault(fault: Fault) -> Iterator[str]:
    cures = ", or ".join(" and ".join(f"`{step}`" for step in cure) for cure in fault.cures)
    yield f"### {fault.name}\n"
    yield f"{fault.description} It is {fault.kind}, in the node `{fault.node}`.\n"
    yield f"Cured by {cures}.\n"
    of_frames = "a frame without it, with it and cured"
    seen = of_frames if fault.effect else "messages over time, with its ripples and its repair"
    yield f"![{fault.name}: {seen}](pictures/{fault.name}.webp)\n"
