"""Sets of frames for training, calibration and tests: rendered, or of a bag."""

import hashlib
import json
import math
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Final, Self, TypeAlias

import numpy as np
import numpy.typing as npt

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
    render_views,
)
from sunset.errors import OutputError
from sunset.files.outputs import write_text
from sunset.processes.workers import Progress, Stages, spread
from sunset_lab.architecture import HEIGHT, WIDTH

TRAINING_TOWNS: Final = (2, 3, 4, 5, 6)
VALIDATION_TOWN: Final = 7
TEST_TOWN: Final = 8
COURSES_DEG: Final = (50.0, 140.0)
"""Directions of the two flights over the validation town; the first is the default flight's."""

DEFAULT_FRAMES: Final = 5500
FURTHER_FRAMES: Final = 20_000
"""About how many frames a model is trained on, and trained further."""

_CHUNK: Final = 50
_PASSAGE: Final = 200
"""The number of frames of each flight over the validation town."""
_LEAST_PASSAGE: Final = 10
"""The least number of consecutive frames that thresholds can be chosen on."""
_PLAN: Final = "plan.json"
_FINISHED: Final = "finished"
"""The array beside a set's own that tells which frames are rendered."""

Images: TypeAlias = tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint16], npt.NDArray[np.uint8]]
"""A frame: colours, depth and labels."""


@dataclass(frozen=True)
class FrameSet:
    """Frames in arrays, in memory or mapped from files."""

    bgr: npt.NDArray[np.uint8]  # (N, H, W, 3)
    depth: npt.NDArray[np.uint16]  # (N, H, W)
    labels: npt.NDArray[np.uint8]  # (N, H, W), class indices, or `IGNORED`

    def __len__(self) -> int:
        return len(self.bgr)

    def images(self, index: int) -> Images:
        """Return a frame."""
        return np.asarray(self.bgr[index]), np.asarray(self.depth[index]), np.asarray(self.labels[index])

    def spread_out(self, count: int) -> "FrameSet":
        """Return at most `count` frames at regular distances."""
        chosen = np.linspace(0, len(self) - 1, min(count, len(self))).astype(int)
        return FrameSet(self.bgr[chosen], self.depth[chosen], self.labels[chosen])

    def digest(self) -> str:
        """Return a short checksum of the frames."""
        digest = hashlib.sha256()
        for array in vars(self).values():
            digest.update(np.ascontiguousarray(array).data)
        return digest.hexdigest()[:12]

    @classmethod
    def load(cls, folder: Path) -> Self:
        """Map the arrays of a folder; changes of them stay in memory."""
        names = cls.__dataclass_fields__
        return cls(**{name: np.load(folder / f"{name}.npy", mmap_mode="c") for name in names})

    def save(self, folder: Path) -> None:
        """Write the arrays into a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        for name, array in vars(self).items():
            np.save(folder / f"{name}.npy", array)


@dataclass(frozen=True, slots=True)
class Views:
    """Random views of a town, in the default flight's setting (50 m, 60°, noon, clear) or in all settings."""

    town: int
    count: int
    seed: int
    flight: bool

    def render(self, start: int, count: int) -> Iterator[Frame]:
        """Render some of the views."""
        return render_views(
            town=self.town,
            count=count,
            seed=self.seed,
            start=start,
            heights=(50,) if self.flight else HEIGHTS_M,
            pitches=(60,) if self.flight else PITCHES_DEG,
            times=("noon",) if self.flight else TIMES,
            weathers=("clear",) if self.flight else WEATHERS,
        )


FramePlan: TypeAlias = tuple[Views, ...]
"""The frames of a set, never of town 1, the default flight's."""


def frame_plans(frames: int, *, further: bool) -> dict[str, FramePlan]:
    """Return the plans of the sets of views for a training with about so many frames.

    Of the training frames, 8 in 11 are in the default flight's setting; 2 in 5 where a model is trained further, whose
    weights know this setting best.
    """
    flight, other = (2, 3) if further else (8, 3)
    towns, held_out = len(TRAINING_TOWNS), math.ceil(150 * _held_out(frames))
    kinds = (
        (math.ceil(frames * flight / (towns * (flight + other))), 1, True),
        (math.ceil(frames * other / (towns * (flight + other))), 2, False),
    )
    return {
        "train": tuple(Views(town, *kind) for town in TRAINING_TOWNS for kind in kinds),
        "validation": (Views(VALIDATION_TOWN, held_out, 3, flight=True),),
        "test": (Views(TEST_TOWN, held_out, 3, flight=True),),
    }


def _held_out(frames: int) -> float:
    """Return the share of the held-out frames to render: fewer for a training with fewer frames than the default."""
    return min(frames / DEFAULT_FRAMES, 1.0)


@dataclass(frozen=True, slots=True)
class FrameSets:
    """The frames of a training: for the weights, and of two other towns.

    Temperatures and thresholds come from `validation_flight`, frames of flights; the others are random views.
    """

    train: FrameSet
    validation: FrameSet
    validation_flight: FrameSet
    test: FrameSet


def titled(progress: Stages | None, title: str) -> Progress | None:
    """Return the progress of a stage with this title."""
    return None if progress is None else partial(progress, title)


def render_sets(
    frames: int, folder: Path, *, further: bool = False, jobs: int = 2, progress: Stages | None = None
) -> FrameSets:
    """Render all sets as far as they are missing: views into folders, flights into the cache; as `frame_plans`."""
    views = {
        name: render_set(plan, folder / name, jobs=jobs, progress=titled(progress, name))
        for name, plan in frame_plans(frames, further=further).items()
    }
    passage = max(math.ceil(_PASSAGE * _held_out(frames)), _LEAST_PASSAGE)
    flight = validation_flight((HEIGHT, WIDTH), count=passage, jobs=jobs, progress=progress)
    return FrameSets(**views, validation_flight=flight)


def render_set(plan: FramePlan, folder: Path, *, jobs: int = 2, progress: Progress | None = None) -> FrameSet:
    """Render a set into a folder, as far as chunks of 50 frames are missing, and map it.

    With `jobs` of 1, this process renders. `progress` is called with frames done and frames in all.
    """
    try:
        finished = _finished_frames(plan, folder)
        missing = [chunk for chunk in _chunks(plan) if not finished[chunk[0]]]

        def note(done: int, _: int) -> None:
            if progress is not None:
                left = sum(count for *_, count in missing[done:])
                progress(len(finished) - left, len(finished))

        deque(spread(partial(_render, folder), missing, jobs=jobs, progress=note), maxlen=0)
        return FrameSet.load(folder)
    except OSError as error:
        raise OutputError(
            f"The training frames cannot be written to {folder}: {error.strerror or error}."
        ) from error


def _finished_frames(plan: FramePlan, folder: Path) -> npt.NDArray[np.bool_]:
    """Return which frames of a plan are in a folder, after preparing it."""
    folder.mkdir(parents=True, exist_ok=True)
    wanted = json.dumps({"renderer": RENDER_VERSION, "views": [asdict(views) for views in plan]}, indent=1)
    document, names = folder / _PLAN, sorted(path.name for path in folder.iterdir())
    if not names:
        write_text(document, wanted)
    elif not document.exists() or document.read_text(encoding="utf-8") != wanted:
        raise OutputError(
            f"The folder {folder} holds {names[0]}, which is not of this training's frames: name another work folder, "
            "or delete this one."
        )
    if f"{_FINISHED}.npy" not in names:
        total = sum(views.count for views in plan)
        shape = (total, HEIGHT, WIDTH)  # blank arrays take no memory
        blank = FrameSet(
            np.zeros((*shape, 3), np.uint8), np.zeros(shape, np.uint16), np.zeros(shape, np.uint8)
        )
        blank.save(folder)  # fails now if the disk is too small
        np.save(folder / _FINISHED, np.zeros(total, np.bool_))
    finished: npt.NDArray[np.bool_] = np.load(folder / f"{_FINISHED}.npy")
    return finished


def _chunks(plan: FramePlan) -> Iterator[tuple[int, Views, int, int]]:
    """Yield chunks: the place in the set, the views, the first of them, and their number."""
    place = 0
    for views in plan:
        for start in range(0, views.count, _CHUNK):
            count = min(_CHUNK, views.count - start)
            yield place, views, start, count
            place += count


def _render(folder: Path, chunk: tuple[int, Views, int, int]) -> None:
    """Render a chunk into its place in the arrays of a folder."""
    place, views, start, count = chunk
    frames = _stacked(list(views.render(start, count)))
    for name, array in (*vars(frames).items(), (_FINISHED, np.True_)):
        stored = np.load(folder / f"{name}.npy", mmap_mode="r+")
        stored[place : place + count] = array
        stored.flush()


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
    count: int = _PASSAGE,
    jobs: int | None = None,
    progress: Stages | None = None,
) -> FrameSet:
    """Return the flights on which thresholds are chosen, rendered once and kept in the cache folder.

    `size` is height and width of a frame in pixels, and `count` the frames of each of the two flights. `jobs` and
    `progress` are as in `flight_bag`.
    """
    rendering = titled(progress, "Rendering the validation flights (once)")
    parts = []
    for course in COURSES_DEG:
        plan = FlightPlan(town=VALIDATION_TOWN, frames=count, course_deg=course, size=size)
        parts.append(vars(frames_of_bag(flight_bag(plan, progress=rendering, jobs=jobs))).values())
    return FrameSet(*map(np.concatenate, zip(*parts, strict=True)))
