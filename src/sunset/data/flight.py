"""Flights that SUNSET renders: their plans, their frames, and the cache folder that keeps them."""

import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import asdict
from functools import lru_cache, partial, wraps
from itertools import chain, islice
from pathlib import Path
from typing import Final, ParamSpec

import sunset_town as town
from sunset.data.bag import write_bag
from sunset.errors import DataError, InvalidInputError, MissingExtraError, OutputError
from sunset.files.inputs import file_digest, read_text
from sunset.flights import FlightSpec
from sunset.processes.workers import Progress, check_jobs, processors, worker_pool
from sunset_town import LENGTH_M, RENDER_VERSION, Flight, Frame, MissingEmbreeError, TownError

P = ParamSpec("P")


@contextmanager
def _town_errors() -> Iterator[None]:
    """Turn the town's errors into SUNSET's."""
    try:
        yield
    except MissingEmbreeError as error:
        raise MissingExtraError(
            "Rendering a flight needs embreex, which is not installed and has no wheels for some platforms: fly a bag "
            "(--bag, 'sunset data import'), or copy the cache folder (~/.cache/sunset, or SUNSET_CACHE_DIR) of a "
            "computer that has rendered the flight."
        ) from error
    except TownError as error:
        raise InvalidInputError(str(error)) from error


def _translated(render: Callable[P, Iterator[Frame]]) -> Callable[P, Iterator[Frame]]:
    @wraps(render)
    def frames(*args: P.args, **kwargs: P.kwargs) -> Iterator[Frame]:
        with _town_errors():
            yield from render(*args, **kwargs)

    return frames


render_frames = _translated(town.render_frames)
render_views = _translated(town.render_views)


class FlightPlan(Flight):
    """The plan of a flight that SUNSET renders, with the arguments of `sunset_town.Flight`.

    Raises:
        InvalidInputError: a value is out of its range.
    """

    __slots__ = ()

    def __post_init__(self) -> None:
        with _town_errors():
            super().__post_init__()

    @classmethod
    def of(cls, spec: FlightSpec, frames: int) -> "FlightPlan":
        """Return the plan of a rendered flight of so many frames; everything else is as in the default flight.

        Raises:
            InvalidInputError: the flight would be too long.
        """
        return cls(
            town=spec.town,
            frames=frames,
            height=spec.height,
            pitch_deg=spec.angle,
            time=spec.time,
            weather=spec.weather,
            seed=spec.seed,
        )


DEFAULT_FLIGHT: Final = FlightPlan()
"""The flight that experiments use: 40 s at 10 Hz over town 1, 50 m high, looking 60° down."""

LONGEST: Final = int(LENGTH_M / DEFAULT_FLIGHT.speed * DEFAULT_FLIGHT.rate_hz)
"""The greatest number of frames of a flight at the default flight's speed and rate."""
_STEP: Final = 100


def frames_for(needed: int) -> int:
    """Return the number of frames to render for an experiment that needs so many.

    It is the default flight's number, unless more frames are needed. Then there are at least 100 more than
    needed, as far as the flight can be that long, so that every seed can begin at another frame.

    >>> frames_for(260), frames_for(410), frames_for(1260), frames_for(5000)
    (400, 600, 1333, 1333)
    """
    if needed <= DEFAULT_FLIGHT.frames:
        return DEFAULT_FLIGHT.frames
    return min(-(-(needed + _STEP) // _STEP) * _STEP, LONGEST)


CHECKSUM_FILE: Final = "checksum.json"
_BAG: Final = "flight"
BATCH: Final = 10
"""Frames that a process renders at a time."""
RENDERING: Final = "Rendering"
"""The name of rendering in progress lines."""


def cache_folder() -> Path:
    """Return the cache folder, which may not exist yet.

    It is `SUNSET_CACHE_DIR` if set, else `sunset` in `XDG_CACHE_HOME`, else `~/.cache/sunset`.
    """
    if own := os.environ.get("SUNSET_CACHE_DIR"):
        return Path(own)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "sunset"


def flights_folder() -> Path:
    """Return the folder of rendered flights and facts about them, which may not exist yet."""
    return cache_folder() / "flights"


def default_flight(*, progress: Progress | None = None, jobs: int | None = None) -> Path:
    """Return `flight_bag` of the flight that experiments use."""
    return flight_bag(DEFAULT_FLIGHT, progress=progress, jobs=jobs)


def flight_bag(plan: FlightPlan, *, progress: Progress | None = None, jobs: int | None = None) -> Path:
    """Return the bag of a flight, as `flight_bags`."""
    return flight_bags([plan], progress=progress, jobs=jobs)[0]


def flight_bags(
    plans: Sequence[FlightPlan], *, progress: Progress | None = None, jobs: int | None = None
) -> list[Path]:
    """Return the bags of flights, rendered on first use by several processes, and kept by `kept_bag`.

    It waits for other processes of this computer that render into the same cache folder.

    Args:
        plans: of the flights.
        progress: called with (frames done, frames in all) of the rendered flights.
        jobs: number of processes; by default, the number of processors, at most 8. It changes no byte.

    Raises:
        InvalidInputError: `jobs` is less than 1, or a flight cannot be flown as planned.
        OutputError: the cache folder cannot be written.
        SunsetError: a worker process was killed.
    """
    check_jobs(jobs)
    missing = [plan for plan in dict.fromkeys(plans) if not _is_intact(flight_place(plan).parent)]
    with _locked() if missing else nullcontext():  # an unwritable folder fails before anything is rendered
        missing = [plan for plan in missing if not _is_intact(flight_place(plan).parent)]
        with _rendered(missing, progress, jobs) as frames:
            for plan in missing:
                own = partial(islice, frames, plan.frames)
                kept_bag(f"town{plan.town}", asdict(plan), own, plan.stamps_ns())
    return list(map(flight_place, plans))


@contextmanager
def _locked() -> Iterator[None]:
    """Make the folder of flights, and keep other processes of this computer from rendering into it."""
    import fcntl  # noqa: PLC0415  not on every system

    with _writing():
        flights_folder().mkdir(parents=True, exist_ok=True)
        lock = os.open(flights_folder(), os.O_RDONLY)
    try:
        with _writing():
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield
    finally:
        os.close(lock)


def flight_place(plan: FlightPlan) -> Path:
    """Return the place of a flight's bag, which may not exist yet."""
    return _home(f"town{plan.town}", asdict(plan)) / _BAG


def bag_checksum(path: Path) -> str:
    """Return the SHA-256 over the files of a bag, in hexadecimal; it is computed again only if they have changed.

    Raises:
        DataError: the bag cannot be read.
    """
    try:
        files = sorted(path.iterdir()) if path.is_dir() else [path]
        states = [(file, file.stat()) for file in files if file.is_file()]
        return _checksum_of(tuple((file, state.st_size, state.st_mtime_ns) for file, state in states))
    except OSError as error:
        raise DataError(f"The bag {path} cannot be read: {error.strerror or error}.") from error


@lru_cache(maxsize=64)
def _checksum_of(states: tuple[tuple[Path, int, int], ...]) -> str:
    digests = b"".join(bytes.fromhex(file_digest(file)) for file, _, _ in states)
    return hashlib.sha256(digests).hexdigest()


def kept_bag(
    name: str, facts: Mapping[str, object], frames: Callable[[], Iterable[Frame]], stamps_ns: Sequence[int]
) -> Path:
    """Return a bag of rendered frames, rendered on first use and kept in the cache folder.

    Every later use verifies the bag's checksum, and renders a bag that does not match again.

    Args:
        name: of its folder, before a checksum of the facts.
        facts: everything that the frames depend on except the renderer, as JSON values.
        frames: renders them.
        stamps_ns: the time of each in nanoseconds.

    Raises:
        OutputError: the cache folder cannot be written.
    """
    home = _home(name, facts)
    bag = home / _BAG
    with _writing():
        if _is_intact(home):
            return bag
        home.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".rendering-", dir=home.parent) as draft:
            finished = Path(draft) / home.name
            write_bag(finished / _BAG, frames(), stamps_ns)
            (finished / CHECKSUM_FILE).write_text(json.dumps(_checksums(finished / _BAG), indent=1) + "\n")
            shutil.rmtree(home, ignore_errors=True)
            finished.rename(home)
    return bag


@contextmanager
def _writing() -> Iterator[None]:
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise OutputError(
            f"The frames cannot be kept in {flights_folder()}: {reason}; set SUNSET_CACHE_DIR to another folder."
        ) from error


def _home(name: str, facts: Mapping[str, object]) -> Path:
    key = json.dumps({"version": RENDER_VERSION, **facts}, sort_keys=True)
    return flights_folder() / f"{name}-{hashlib.sha256(key.encode()).hexdigest()[:16]}"


def _checksums(bag: Path) -> dict[str, str]:
    return {path.name: file_digest(path) for path in sorted(bag.iterdir())}


def _is_intact(home: Path) -> bool:
    """Return whether a kept flight exists and matches its checksums."""
    try:
        expected = json.loads(read_text(home / CHECKSUM_FILE))
        return bool(expected) and expected == _checksums(home / _BAG)
    except (OSError, ValueError):
        return False


@contextmanager
def _rendered(
    plans: Sequence[FlightPlan], progress: Progress | None, jobs: int | None
) -> Iterator[Iterator[Frame]]:
    """Give the frames of flights, one flight after the other; processes render ahead."""
    total = sum(plan.frames for plan in plans)
    batches = [(plan, start) for plan in plans for start in range(0, plan.frames, BATCH)]
    count = min(min(processors(), 8) if jobs is None else jobs, len(batches))

    def counted(batches: Iterable[list[Frame]]) -> Iterator[Frame]:
        for done, frame in enumerate(chain.from_iterable(batches), 1):
            if progress is not None:
                progress(done, total)
            yield frame

    if progress is not None and plans:
        progress(0, total)
    with nullcontext() if count <= 1 else worker_pool(count) as pool:
        yield counted(pool.map(_render_batch, batches) if pool else map(_render_batch, batches))


def _render_batch(batch: tuple[FlightPlan, int]) -> list[Frame]:
    plan, start = batch
    return list(render_frames(plan, range(start, min(start + BATCH, plan.frames))))
