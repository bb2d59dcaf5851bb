"""Rendering the frames that models are trained and tested on."""

import json
import math
from collections.abc import Callable, Iterator
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
    TIMES,
    WEATHERS,
    FlightPlan,
    Frame,
    render_frames,
    render_views,
)
from sunset.data.cache import RENDER_VERSION
from sunset.errors import OutputError
from sunset.processes.workers import worker_pool
from sunset.training.batches import FrameSet
from sunset.training.inputs import HEIGHT, WIDTH

TRAINING_TOWNS: Final = (2, 3, 4, 5, 6)
VALIDATION_TOWN: Final = 7
TEST_TOWN: Final = 8
COURSES_DEG: Final = (50.0, 140.0)
"""Directions of the two flights over a held-out town; the first is the default flight's."""

_CHUNK: Final = 50
_LEAST_PASSAGE: Final = 10
"""Fewer consecutive frames are too few to choose thresholds on."""
_PLAN: Final = "plan.json"
"""Stands beside frames that are all there."""
_PARTIAL: Final = "partial.json"
"""Stands beside frames of which some are there; says which."""
_UNFINISHED: Final = ".tmp"
"""Ends the name of a file that is being written."""


@dataclass(frozen=True, slots=True)
class Views:
    """Random views of one town: only in the default flight's setting (50 m, 60°, noon, clear), or in all settings."""

    town: int
    count: int
    seed: int
    flight: bool


@dataclass(frozen=True, slots=True)
class Passage:
    """Consecutive frames, ten a second, of a flight like the default one over another town, in some direction."""

    town: int
    count: int
    course_deg: float


FramePlan: TypeAlias = tuple[Views | Passage, ...]
"""Which frames a set consists of; the default flight's town, 1, must be in none of them."""


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

    @classmethod
    def of(cls, frames: int, *, flight: int = 8, other: int = 3) -> "FrameCounts":
        """Return counts with about so many training frames, and with as much fewer held-out ones; no fewer than work.

        Training frames in the default flight's setting and in all settings are as `flight` to `other`.

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
    """Everything that a training run looks at: what weights are learned on, and frames of two other towns.

    Of these there are random views, and consecutive frames of flights; temperatures and thresholds come from
    `validation_flight`.
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
    """Render all sets into a folder each in a folder, but those that are there already.

    `progress` is called with the set's name, frames done and frames in all.

    Raises:
        OutputError: the folder cannot be written.
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
    frames = list(_frames(views, start, count))
    bgr, depth = np.stack([frame.rgb for frame in frames]), np.stack([frame.depth for frame in frames])
    labels = CLASS_OF_CARLA_ID[np.stack([frame.labels for frame in frames])]
    FrameSet(bgr, depth, labels).write_into(folder, place)


def render_set(
    plan: FramePlan, folder: Path, *, jobs: int = 2, progress: Callable[[int, int], None] | None = None
) -> FrameSet:
    """Render a set into a folder, or what is missing of it there, and map it.

    Chunks of 50 frames are kept as they are finished, so that an interrupted call loses no others. One job is done in
    this process. `progress` is called with frames done and frames in all.

    Raises:
        OutputError: the folder cannot be written, or holds something else, frames of another plan for instance.
    """
    wanted = {"renderer": RENDER_VERSION, "views": [asdict(views) for views in plan]}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if not _is_complete(folder, wanted):
            _render_missing(plan, wanted, folder, jobs, progress)
    except OSError as error:
        raise OutputError(
            f"The training frames cannot be written to {folder}: {error.strerror or error}."
        ) from error
    return FrameSet.load(folder)


def _is_complete(folder: Path, wanted: dict[str, object]) -> bool:
    """Return whether a folder holds all frames of a plan, and not only some, or none yet."""
    names = sorted(path.name for path in folder.iterdir() if path.suffix != _UNFINISHED)
    if not names:
        return False
    for name in (_PLAN, _PARTIAL):
        with suppress(AttributeError, FileNotFoundError, ValueError):
            if json.loads((folder / name).read_text(encoding="utf-8")).items() >= wanted.items():
                return name == _PLAN
    raise OutputError(
        f"The folder {folder} holds {names[0]}, which is not of this training's frames: name another work folder, or "
        "delete this one."
    )


def _render_missing(
    plan: FramePlan,
    wanted: dict[str, object],
    folder: Path,
    jobs: int,
    progress: Callable[[int, int], None] | None,
) -> None:
    """Render the chunks that are not in the folder yet."""
    chunks = list(_chunks(plan))
    total = sum(views.count for views in plan)
    finished: list[int] = []
    if (folder / _PARTIAL).exists():
        finished += json.loads((folder / _PARTIAL).read_text(encoding="utf-8"))["finished"]
    if not finished:
        _write(folder / _PARTIAL, wanted | {"finished": finished})
        FrameSet.blank(total, HEIGHT, WIDTH).save(folder)  # a disk that is too small shows now
    missing = [number for number in range(len(chunks)) if number not in finished]

    def note(number: int) -> None:
        finished.append(number)
        _write(folder / _PARTIAL, wanted | {"finished": finished})
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
    (folder / _PARTIAL).unlink()


def _chunks(plan: FramePlan) -> Iterator[tuple[int, Views | Passage, int, int]]:
    """Yield what is rendered at once: its place in the set, of which views, from which of them on, and how many."""
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
