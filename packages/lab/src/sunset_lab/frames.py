"""The frames for training, calibration and tests: rendered, or of a bag."""

import json
import math
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import as_completed
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Final, TypeAlias

import numpy as np

from sunset.classes import CLASS_OF_CARLA_ID
from sunset.data import (
    HEIGHTS_M,
    PITCHES_DEG,
    RENDER_VERSION,
    TIMES,
    WEATHERS,
    FlightPlan,
    Frame,
    flight_bag,
    read_bag,
    render_frames,
    render_views,
)
from sunset.errors import OutputError
from sunset.processes.workers import Stages, worker_pool
from sunset_lab.batches import FrameSet
from sunset_lab.inputs import HEIGHT, WIDTH

TRAINING_TOWNS: Final = (2, 3, 4, 5, 6)
VALIDATION_TOWN: Final = 7
TEST_TOWN: Final = 8
COURSES_DEG: Final = (50.0, 140.0)
"""Directions of the two flights over a held-out town; the first is the default flight's."""

_CHUNK: Final = 50
_LEAST_PASSAGE: Final = 10
"""The least number of consecutive frames that thresholds can be chosen on."""
_PLAN: Final = "plan.json"
"""The file beside a set, with its plan and, while the set is incomplete, its finished chunks."""
_UNFINISHED: Final = ".tmp"
"""The suffix of a file while it is written."""


@dataclass(frozen=True, slots=True)
class Views:
    """Random views of a town, in the default flight's setting (50 m, 60°, noon, clear) or in all settings."""

    town: int
    count: int
    seed: int
    flight: bool


@dataclass(frozen=True, slots=True)
class Passage:
    """Consecutive frames, ten a second, of a flight like the default flight over another town, on a course."""

    town: int
    count: int
    course_deg: float


FramePlan: TypeAlias = tuple[Views | Passage, ...]
"""The frames of a set, never of town 1, the default flight's."""


@dataclass(frozen=True, slots=True)
class FrameCounts:
    """The numbers of frames to render.

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

    @classmethod
    def of(cls, frames: int, *, flight: int = 8, other: int = 3) -> "FrameCounts":
        """Return counts for about `frames` training frames, and proportionally fewer held-out frames.

        `flight` and `other` are the proportions of training frames in the default flight's setting and in all settings.

        >>> FrameCounts.of(550)
        FrameCounts(flight=80, other=30, held_out=15, passage=20)
        """
        most = cls()
        of_town = len(TRAINING_TOWNS) * (flight + other)
        held_out = min(frames / (len(TRAINING_TOWNS) * (most.flight + most.other)), 1.0)
        return cls(
            flight=math.ceil(frames * flight / of_town),
            other=math.ceil(frames * other / of_town),
            held_out=math.ceil(most.held_out * held_out),
            passage=max(math.ceil(most.passage * held_out), _LEAST_PASSAGE),
        )

    def plans(self) -> dict[str, FramePlan]:
        """Return the plan of each set."""
        plans: dict[str, FramePlan] = {"train": ()}
        for town in TRAINING_TOWNS:
            plans["train"] += (
                Views(town, self.flight, 1, flight=True),
                Views(town, self.other, 2, flight=False),
            )
        for kind, town in (("validation", VALIDATION_TOWN), ("test", TEST_TOWN)):
            plans[kind] = (Views(town, self.held_out, 3, flight=True),)
            plans[f"{kind}_flight"] = tuple(Passage(town, self.passage, course) for course in COURSES_DEG)
        return plans


@dataclass(frozen=True, slots=True)
class FrameSets:
    """The frames of a training: for the weights, and of two other towns.

    The other towns have sets of random views, and of consecutive frames of flights. Temperatures and thresholds come
    from `validation_flight`.
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
    """Render all sets, each into its own folder, as far as they are missing.

    `progress` is called with the set's name, frames done and frames in all.
    """
    sets = {}
    for name, plan in counts.plans().items():
        note = partial(progress, name) if progress else None
        sets[name] = render_set(plan, folder / name, jobs=jobs, progress=note)
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


def _render(folder: Path, place: int, views: Views | Passage, start: int, count: int) -> None:
    """Render a chunk into its place in the arrays of a folder."""
    _stacked(list(_frames(views, start, count))).write_into(folder, place)


def render_set(
    plan: FramePlan, folder: Path, *, jobs: int = 2, progress: Callable[[int, int], None] | None = None
) -> FrameSet:
    """Render a set into a folder, as far as chunks of 50 frames are missing, and map it.

    With `jobs` of 1, this process renders. `progress` is called with frames done and frames in all.
    """
    wanted = {"renderer": RENDER_VERSION, "views": [asdict(views) for views in plan]}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        finished = _finished_chunks(folder, wanted)
        if finished is not None:
            _render_missing(plan, wanted, folder, finished, jobs=jobs, progress=progress)
    except OSError as error:
        raise OutputError(
            f"The training frames cannot be written to {folder}: {error.strerror or error}."
        ) from error
    return FrameSet.load(folder)


def _finished_chunks(folder: Path, wanted: dict[str, object]) -> list[int] | None:
    """Return the finished chunks of a plan in a folder; None if all are finished."""
    names = sorted(path.name for path in folder.iterdir() if path.suffix != _UNFINISHED)
    if not names:
        return []
    with suppress(AttributeError, FileNotFoundError, ValueError):
        document = json.loads((folder / _PLAN).read_text(encoding="utf-8"))
        if document.items() >= wanted.items():
            finished: list[int] | None = document.get("finished")
            return finished
    raise OutputError(
        f"The folder {folder} holds {names[0]}, which is not of this training's frames: name another work folder, or "
        "delete this one."
    )


def _render_missing(
    plan: FramePlan,
    wanted: dict[str, object],
    folder: Path,
    finished: list[int],
    *,
    jobs: int,
    progress: Callable[[int, int], None] | None,
) -> None:
    """Render the chunks that the folder lacks."""
    chunks = list(_chunks(plan))
    total = sum(views.count for views in plan)
    if not finished:
        _write(folder / _PLAN, wanted | {"finished": finished})
        FrameSet.blank(total, HEIGHT, WIDTH).save(folder)  # fails now if the disk is too small
    missing = [number for number in range(len(chunks)) if number not in finished]

    def note(number: int) -> None:
        finished.append(number)
        _write(folder / _PLAN, wanted | {"finished": finished})
        if progress is not None:
            progress(sum(chunks[number][-1] for number in finished), total)

    if jobs == 1:
        for number in missing:
            _render(folder, *chunks[number])
            note(number)
    else:
        with worker_pool(jobs) as pool:
            futures = {pool.submit(_render, folder, *chunks[number]): number for number in missing}
            for future in as_completed(futures):
                future.result()
                note(futures[future])
    _write(folder / _PLAN, wanted)


def _chunks(plan: FramePlan) -> Iterator[tuple[int, Views | Passage, int, int]]:
    """Yield chunks: the place in the set, the views, the first of them, and their number."""
    place = 0
    for views in plan:
        for start in range(0, views.count, _CHUNK):
            count = min(_CHUNK, views.count - start)
            yield place, views, start, count
            place += count


def _write(path: Path, document: dict[str, object]) -> None:
    temporary = path.with_suffix(_UNFINISHED)
    temporary.write_text(json.dumps(document, indent=1), encoding="utf-8")
    temporary.replace(path)


def _stacked(frames: Sequence[Frame]) -> FrameSet:
    return FrameSet(
        np.stack([frame.rgb for frame in frames]),
        np.stack([frame.depth for frame in frames]),
        CLASS_OF_CARLA_ID[np.stack([frame.labels for frame in frames])],
    )


def frames_of_bag(path: Path, size: tuple[int, int] | None = None) -> FrameSet:
    """Return the frames of a bag, resampled to a height and width unless `size` is None."""
    with read_bag(path, size=size) as reader:
        return _stacked([reader.frame(index) for index in range(len(reader))])


def validation_flight(
    size: tuple[int, int],
    *,
    count: int = FrameCounts().passage,
    jobs: int | None = None,
    progress: Stages | None = None,
) -> FrameSet:
    """Return the flights on which thresholds are chosen, rendered once and kept in the cache folder.

    `size` is height and width of a frame in pixels, and `count` the frames of each of the two flights. `jobs` and
    `progress` are as in `flight_bag`.
    """
    rendering = partial(progress, "Rendering the validation flights (once)") if progress else None
    parts = []
    for course in COURSES_DEG:
        plan = FlightPlan(town=VALIDATION_TOWN, frames=count, course_deg=course, size=size)
        parts.append(frames_of_bag(flight_bag(plan, progress=rendering, jobs=jobs)))
    return FrameSet(
        np.concatenate([part.bgr for part in parts]),
        np.concatenate([part.depth for part in parts]),
        np.concatenate([part.labels for part in parts]),
    )
