"""The moment at which a page opens tells something."""

import msgspec
import pytest
from tests.viewing.conftest import Shown

from sunset.viewing.document import Happening, Page, RunView
from sunset.viewing.opening import opening

pytestmark = pytest.mark.xdist_group("viewing")  # the runs that are shown are made once


@pytest.fixture
def view(ten: Shown) -> RunView:
    return msgspec.convert(ten.data, Page).runs[0]


def with_iou(view: RunView, iou: list[float | None]) -> RunView:
    return msgspec.structs.replace(view, frames=msgspec.structs.replace(view.frames, iou=iou))


def test_a_run_opens_when_its_first_fault_shows(ten: Shown, view: RunView) -> None:
    came = ten.run.timeline.injections[0].time
    holds = min(one.holds for one in ten.run.episodes if one.injected)
    earlier = Happening(came - 0.1, "symptom", "F4 (not injected)")

    assert ten.data["opening"] == holds > came
    assert opening([msgspec.structs.replace(view, events=[earlier, *view.events])]) == holds


def test_a_run_without_a_symptom_opens_when_its_fault_comes_and_one_without_a_fault_at_0(
    ten: Shown, view: RunView
) -> None:
    calm = msgspec.structs.replace(view, events=[])

    assert opening([calm]) == ten.run.timeline.injections[0].time
    assert opening([msgspec.structs.replace(calm, faults=[])]) == 0.0


def test_two_runs_open_where_they_differ_most(view: RunView) -> None:
    frames = len(view.frames.times)
    good: list[float | None] = [0.6] * frames
    blinks = [*good[:30], None, *good[31:]]  # a frame is no difference that lasts
    lost = [*blinks[:60], *[None] * 30, *blinks[90:]]

    time = opening([with_iou(view, good), with_iou(view, lost)])
    assert view.frames.times[60] < time < view.frames.times[89]
    alike = [with_iou(view, good), with_iou(view, good)]
    assert opening(alike) == opening([view])
