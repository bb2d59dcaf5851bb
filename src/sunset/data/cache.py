"""Rendered flights, kept in the user's cache folder."""

import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Final

from sunset.data.bag import write_bag
from sunset.data.flight import DEFAULT_FLIGHT, FlightPlan, render_frames
from sunset.data.frame import Frame
from sunset.errors import OutputError
from sunset.input_files import file_digest, read_text
from sunset.workers import Progress, check_jobs, processors, worker_pool

RENDER_VERSION: Final = 2
"""Grows whenever a rendered byte changes, so that flights in users' caches are rendered anew."""

CHECKSUM_FILE: Final = "checksum.json"
BATCH: Final = 10


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
    """Return the bag of a flight, rendered on first use as `render_parallel` does it, and kept as by `kept_bag`.

    Raises:
        InvalidInputError: `jobs` is less than 1.
        OutputError: the cache folder cannot be written.
    """
    return kept_bag(
        f"town{plan.town}",
        asdict(plan),
        lambda: render_parallel(plan, progress=progress, jobs=jobs),
        plan.stamps_ns(),
    )


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
    key = json.dumps({"version": RENDER_VERSION, **facts}, sort_keys=True)
    home = cache_folder() / "flights" / f"{name}-{hashlib.sha256(key.encode()).hexdigest()[:16]}"
    bag = home / "flight"
    try:
        if _is_intact(home):
            return bag
        home.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".rendering-", dir=home.parent) as draft:
            made = Path(draft) / home.name
            write_bag(made / bag.name, frames(), stamps_ns)
            (made / CHECKSUM_FILE).write_text(json.dumps(_checksums(made / bag.name), indent=1) + "\n")
            _move(made, home)
    except OSError as error:
        reason = error.strerror or str(error)
        raise OutputError(
            f"The frames cannot be kept in {home.parent}: {reason}; set SUNSET_CACHE_DIR to another folder."
        ) from error
    return bag


def _checksums(bag: Path) -> dict[str, str]:
    """Return file name → SHA-256 of everything in a bag's folder."""
    return {path.name: file_digest(path) for path in sorted(bag.iterdir())}


def _is_intact(home: Path) -> bool:
    """Say whether a kept flight is there and matches its checksums."""
    try:
        expected = json.loads(read_text(home / CHECKSUM_FILE))
        return bool(expected) and expected == _checksums(home / "flight")
    except (FileNotFoundError, NotADirectoryError, ValueError):
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


def render_parallel(
    plan: FlightPlan, *, progress: Progress | None = None, jobs: int | None = None
) -> Iterator[Frame]:
    """Yield all frames of a flight in order, rendered by several processes; how many these are changes no byte.

    Args:
        plan: of the flight.
        progress: called with (frames done, frames in all) before the first frame and after each.
        jobs: how many processes render; as many as there are processors, at most 8, if not given.

    Raises:
        InvalidInputError: `jobs` is less than 1.
        SunsetError: a worker process was killed.
    """
    check_jobs(jobs)
    count = min(processors(), 8) if jobs is None else jobs
    frames = render_frames(plan) if count == 1 else _from_processes(plan, count)
    if progress is not None:
        progress(0, plan.frames)
    for done, frame in enumerate(frames, start=1):
        yield frame
        if progress is not None:
            progress(done, plan.frames)


def _render_batch(plan: FlightPlan, start: int) -> list[Frame]:
    return list(render_frames(plan, range(start, min(start + BATCH, plan.frames))))


def _from_processes(plan: FlightPlan, jobs: int) -> Iterator[Frame]:
    starts = range(0, plan.frames, BATCH)
    with worker_pool(min(jobs, len(starts))) as pool:
        for batch in pool.map(_render_batch, [plan] * len(starts), starts):
            yield from batch
