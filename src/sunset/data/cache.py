"""Rendered flights, kept in the user's cache folder."""

import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import contextmanager, nullcontext
from dataclasses import asdict
from functools import lru_cache, partial
from pathlib import Path
from typing import Final

from sunset.data.bag import write_bag
from sunset.data.flight import DEFAULT_FLIGHT, FlightPlan, render_frames
from sunset.data.frame import Frame
from sunset.errors import DataError, OutputError
from sunset.input_files import file_digest, read_text
from sunset.processes.workers import Progress, check_jobs, processors, worker_pool

RENDER_VERSION: Final = 2
"""Grows whenever a rendered byte changes, so that flights in users' caches are rendered anew."""

CHECKSUM_FILE: Final = "checksum.json"
_BAG: Final = "flight"
BATCH: Final = 10
RENDERING: Final = "Rendering"
"""What is done where flights are rendered, in words."""


def cache_folder() -> Path:
    """Return the folder that things made once are kept in; it need not exist yet.

    It is `SUNSET_CACHE_DIR` if set, else `sunset` in `XDG_CACHE_HOME`, else `~/.cache/sunset`.
    """
    if own := os.environ.get("SUNSET_CACHE_DIR"):
        return Path(own)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "sunset"


def default_flight(*, progress: Progress | None = None, jobs: int | None = None) -> Path:
    """Return `flight_bag` of the flight that experiments use."""
    return flight_bag(DEFAULT_FLIGHT, progress=progress, jobs=jobs)


def flight_bag(plan: FlightPlan, *, progress: Progress | None = None, jobs: int | None = None) -> Path:
    """Return the bag of a flight, rendered on first use and kept as by `kept_bag`; as `flight_bags`."""
    return flight_bags([plan], progress=progress, jobs=jobs)[0]


def flight_bags(
    plans: Sequence[FlightPlan], *, progress: Progress | None = None, jobs: int | None = None
) -> list[Path]:
    """Return the bags of flights, rendered on first use by several processes, and kept as by `kept_bag`.

    Who else on this computer renders into the same cache folder is waited for.

    Args:
        plans: of the flights.
        progress: called with (frames done, frames in all) of those that are rendered.
        jobs: how many processes render; as many as there are processors, at most 8, if not given. It changes no byte.

    Raises:
        InvalidInputError: `jobs` is less than 1, or a flight cannot be flown as planned.
        OutputError: the cache folder cannot be written.
        SunsetError: a worker process was killed.
    """
    check_jobs(jobs)
    missing = [plan for plan in dict.fromkeys(plans) if not _is_there(plan)]
    with _locked() if missing else nullcontext():  # it is not begun where nothing can be kept
        missing = [plan for plan in missing if not _is_there(plan)]
        with _rendered(missing, progress, jobs) as frames:
            for plan in missing:
                kept_bag(f"town{plan.town}", asdict(plan), partial(frames, plan), plan.stamps_ns())
    return list(map(flight_place, plans))


@contextmanager
def _locked() -> Iterator[None]:
    """Make the folder of flights, and keep other processes of this computer from rendering into it."""
    import fcntl  # noqa: PLC0415  not on every system

    with _translated():
        flights_folder().mkdir(parents=True, exist_ok=True)
        lock = os.open(flights_folder(), os.O_RDONLY)
    try:
        with _translated():
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield
    finally:
        os.close(lock)


def flight_place(plan: FlightPlan) -> Path:
    """Return where the bag of a flight is kept, whether or not it is there."""
    return _home(f"town{plan.town}", asdict(plan)) / _BAG


def bag_checksum(path: Path) -> str:
    """Return the SHA-256 over the files of a bag, in hexadecimal; it is computed once, unless they have changed since.

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

    The bag's checksum is verified on every later use; a bag that does not match is rendered anew.

    Args:
        name: of its folder, before a checksum of the facts.
        facts: all that the frames depend on but the renderer; what `json` can write.
        frames: renders them.
        stamps_ns: the time of each in nanoseconds.

    Raises:
        OutputError: the cache folder cannot be written.
    """
    home = _home(name, facts)
    bag = home / _BAG
    with _translated():
        if _is_intact(home):
            return bag
        home.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".rendering-", dir=home.parent) as draft:
            made = Path(draft) / home.name
            write_bag(made / bag.name, frames(), stamps_ns)
            (made / CHECKSUM_FILE).write_text(json.dumps(_checksums(made / bag.name), indent=1) + "\n")
            _move(made, home)
    return bag


@contextmanager
def _translated() -> Iterator[None]:
    """Turn the operating system's errors into ours."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise OutputError(
            f"The frames cannot be kept in {flights_folder()}: {reason}; set SUNSET_CACHE_DIR to another folder."
        ) from error


def flights_folder() -> Path:
    """Return the folder that flights are kept in, and what is known of them; it need not exist yet."""
    return cache_folder() / "flights"


def _home(name: str, facts: Mapping[str, object]) -> Path:
    """Return the folder of what is rendered with these facts."""
    key = json.dumps({"version": RENDER_VERSION, **facts}, sort_keys=True)
    return flights_folder() / f"{name}-{hashlib.sha256(key.encode()).hexdigest()[:16]}"


def _checksums(bag: Path) -> dict[str, str]:
    """Return file name → SHA-256 of everything in a bag's folder."""
    return {path.name: file_digest(path) for path in sorted(bag.iterdir())}


def _is_intact(home: Path) -> bool:
    """Say whether a kept flight is there and matches its checksums."""
    try:
        expected = json.loads(read_text(home / CHECKSUM_FILE))
        return bool(expected) and expected == _checksums(home / _BAG)
    except (FileNotFoundError, NotADirectoryError, ValueError):
        return False


def _is_there(plan: FlightPlan) -> bool:
    """Say whether a flight need not be rendered; of one that cannot be read, `kept_bag` says why."""
    try:
        return _is_intact(flight_place(plan).parent)
    except OSError:
        return False


def _move(made: Path, home: Path) -> None:
    """Put a finished flight in its place, unless another process has meanwhile."""
    if _is_intact(home):
        return
    if home.exists():
        shutil.rmtree(home)
    try:
        made.rename(home)
    except OSError:
        if not _is_intact(home):
            raise


@contextmanager
def _rendered(
    plans: Sequence[FlightPlan], progress: Progress | None, jobs: int | None
) -> Iterator[Callable[[FlightPlan], Iterator[Frame]]]:
    """Give a function that returns the frames of one of several flights, to be called once for each, in their order.

    Processes render ahead: the next flight is begun while the frames of one are used.
    """
    total, done = sum(plan.frames for plan in plans), 0
    count = min(processors(), 8) if jobs is None else jobs
    batches = {plan: range(0, plan.frames, BATCH) for plan in plans}
    count = min(count, sum(map(len, batches.values())))

    def counted(frames: Iterable[Frame]) -> Iterator[Frame]:
        nonlocal done
        for frame in frames:
            yield frame
            done += 1
            if progress is not None:
                progress(done, total)

    if progress is not None and plans:
        progress(0, total)
    if count <= 1:
        yield lambda plan: counted(render_frames(plan))
        return
    with worker_pool(count) as pool:
        futures = {
            plan: [pool.submit(_render_batch, plan, start) for start in starts]
            for plan, starts in batches.items()
        }
        yield lambda plan: counted(frame for future in _each(futures[plan]) for frame in future.result())


def _each(futures: list[Future[list[Frame]]]) -> Iterator[Future[list[Frame]]]:
    """Yield futures in their order, and keep none that was used, since it has its frames."""
    futures.reverse()
    while futures:
        yield futures.pop()


def _render_batch(plan: FlightPlan, start: int) -> list[Frame]:
    return list(render_frames(plan, range(start, min(start + BATCH, plan.frames))))
