"""The page docs/faults.md, made of the catalogue."""

from collections.abc import Iterator
from typing import Final

from sunset.system import Fault, current_system

_HEAD: Final = """\
# The faults

Eleven faults lead to five failures. A managing system sees the failure, not the fault, so that it has to find out which
of several faults it is. Each is shown here with what cures it. `scripts/draw_pictures` drew the pictures and wrote this
page; `sunset faults show NAME --figure FILE` draws one.

On a picture with frames, the upper row is what the network gets, and the lower row what it makes of that. *IoU* says
how right that is, *entropy* how unsure the network is. On a picture over time, every line is a message, and every
bar a silence. Orange lines are the edges of the depth image: where both images fit, they lie on the edges of things.
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
