"""Rendering the frames that models are trained and tested on."""

import json
import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import as_completed
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np
import numpy.typing as npt

from sunset.classes import CLASS_OF_CARLA_ID
from sunset.data import (
    HEIGHTS_M,
    PITCHES_DEG,
    TIMES,
    WEATHERS,
    FlightPlan,
    Frame,
    render_frames,
    render_views,
)
from sunset.data.cache import RENDER_VERSION
from sunset.errors import OutputError
from sunset.training.batches import ARRAY_FILES, FrameSet
from sunset.workers import worker_pool

__all__ = ["FrameCounts", "FramePlan", "FrameSets", "Passage", "Views", "render_set", "render_sets"]

TRAINING_TOWNS: Final = (2, 3, 4, 5, 6)
VALIDATION_TOWN: Final = 7
TEST_TOWN: Final = 8
COURSES_DEG: Final = (50.0, 140.0)
"""Directions of the two flights over a held-out town; the first is the default flight's."""

_CHUNK: Final = 50
_PLAN: Final = "plan.json"

_Array: TypeAlias = npt.NDArray[Any]


@dataclass(frozen=True, slots=True)
class Views:
    """Random views of one town.

    Attributes:
        town: its number.
        count: frames.
        seed: of the poses.
        flight: only the default flight's setting (50 m, 60°, noon, clear), or all settings.
    """

    town: int
    count: int
    seed: int
    flight: bool


@dataclass(frozen=True, slots=True)
class Passage:
    """Consecutive frames of a flight like the default one over another town.

    Attributes:
        town: its number.
        count: frames, ten a second.
        course_deg: direction of the flight.
    """

    town: int
    count: int
    course_deg: float


@dataclass(frozen=True, slots=True)
class FramePlan:
    """Which frames a set consists of; the default flight's town, 1, must be in none of them."""

    views: tuple[Views | Passage, ...]


@dataclass(frozen=True, slots=True)
class FrameCounts:
    """How many frames are rendered.

    Attributes:
        flight: training frames of each town in the default flight's setting.
        other: training frames of each town in all settings.
        held_out: random views of the validation town, and of the test town.
        passage: consecutive frames of each of two flights over the validation town, and over the test town.
    """

    flight: int = 800
    other: int = 300
    held_out: int = 150
    passage: int = 200

    def plans(self) -> dict[str, FramePlan]:
        """Return the plan of each set."""
        training: list[Views | Passage] = []
        for town in TRAINING_TOWNS:
            training.append(Views(town, self.flight, 1, flight=True))
            training.append(Views(town, self.other, 2, flight=False))
        plans = {"train": FramePlan(tuple(training))}
        for kind, town in (("validation", VALIDATION_TOWN), ("test", TEST_TOWN)):
            plans[kind] = FramePlan((Views(town, self.held_out, 3, flight=True),))
            passages = tuple(Passage(town, self.passage, course) for course in COURSES_DEG)
            plans[f"{kind}_flight"] = FramePlan(passages)
        return plans


@dataclass(frozen=True, slots=True)
class FrameSets:
    """Everything that a training run looks at.

    Attributes:
        train: the weights are learned on these.
        validation: random views of another town.
        validation_flight: consecutive frames over that town; temperatures and thresholds come from these.
        test: random views of a third town.
        test_flight: consecutive frames over that town.
    """

    train: FrameSet
    validation: FrameSet
    validation_flight: FrameSet
    test: FrameSet
    test_flight: FrameSet


def render_sets(
    counts: FrameCounts,
    folder: Path,
    *,
    jobs: int = 2,
    progress: Callable[[str, int, int], None] | None = None,
) -> FrameSets:
    """Render all sets into a folder, but those that are there already.

    Args:
        counts: how many frames.
        folder: receives a folder a set.
        jobs: processes.
        progress: called with the set's name, frames done and frames in all.

    Raises:
        OutputError: the folder cannot be written.
    """
    sets = {
        name: render_set(
            plan, folder / name, jobs=jobs, progress=partial(progress, name) if progress else None
        )
        for name, plan in counts.plans().items()
    }
    return FrameSets(**sets)


def _frames(views: Views | Passage, start: int, count: int) -> Iterator[Frame]:
    if isinstance(views, Passage):
        plan = FlightPlan(town=views.town, frames=views.count, course_deg=views.course_deg)
        return render_frames(plan, range(start, start + count))
    return render_views(
        town=views.town,
        count=count,
        seed=views.seed,
        start=start,
        heights=(50,) if views.flight else HEIGHTS_M,
        pitches=(60,) if views.flight else PITCHES_DEG,
        times=("noon",) if views.flight else TIMES,
        weathers=("clear",) if views.flight else WEATHERS,
    )


def _render(views: Views | Passage, start: int, count: int) -> tuple[_Array, _Array, _Array]:
    frames = list(_frames(views, start, count))
    labels = CLASS_OF_CARLA_ID[np.stack([frame.labels for frame in frames])]
    return np.stack([frame.rgb for frame in frames]), np.stack([frame.depth for frame in frames]), labels


def render_set(
    plan: FramePlan,
    folder: Path,
    *,
    jobs: int = 2,
    progress: Callable[[int, int], None] | None = None,
) -> FrameSet:
    """Render a set into a folder, or map the one that is there if it was made by the same plan.

    Args:
        plan: which frames.
        folder: receives three arrays and the plan; an older set in it is replaced.
        jobs: processes.
        progress: called with frames done and frames in all.

    Raises:
        OutputError: the folder cannot be written, or holds something else.
    """
    views = [asdict(views) for views in plan.views]
    text = json.dumps({"renderer": RENDER_VERSION, "views": views}, indent=1)
    try:
        if (folder / _PLAN).exists() and (folder / _PLAN).read_text(encoding="utf-8") == text:
            return FrameSet.load(folder)
        _remove(folder)
        _render_all(plan, jobs, progress).save(folder)
        (folder / _PLAN).write_text(text, encoding="utf-8")
    except OSError as error:
        raise OutputError(
            f"The training frames cannot be written to {folder}: {error.strerror or error}."
        ) from error
    return FrameSet.load(folder)


def _remove(folder: Path) -> None:
    """Remove an older set of frames, or what an interrupted call left of one, and nothing else."""
    if not folder.exists():
        return
    others = sorted({path.name for path in folder.iterdir()} - {_PLAN, *ARRAY_FILES})
    if others:
        raise OutputError(
            f"The folder {folder} holds {others[0]}, which is none of a training's frames: name another."
        )
    shutil.rmtree(folder)


def _render_all(plan: FramePlan, jobs: int, progress: Callable[[int, int], None] | None) -> FrameSet:
    chunks = [
        (views, start, min(_CHUNK, views.count - start))
        for views in plan.views
        for start in range(0, views.count, _CHUNK)
    ]
    total, done = sum(views.count for views in plan.views), 0
    parts = []
    with worker_pool(jobs) as pool:
        futures = [pool.submit(_render, *chunk) for chunk in chunks]
        counts = dict(zip(futures, (count for _, _, count in chunks), strict=True))
        for future in as_completed(futures):
            done += counts[future]
            if progress is not None:
                progress(done, total)
        parts = [future.result() for future in futures]
    return FrameSet(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))
