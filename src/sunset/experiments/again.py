"""Run a stored run again and check that its messages are the same."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

from msgspec import UNSET

from sunset.errors import RecordError
from sunset.experiments.resources import prepare
from sunset.experiments.run import run_prepared
from sunset.experiments.spec import RunSpec, Settings, Timing
from sunset.experiments.stored_faults import scenario_of
from sunset.flights import FlightSpec
from sunset.recording import RunRecord, StoredRun, read_run
from sunset.recording.reader import check_extensions, first_difference
from sunset.rmw.backends import SIMULATED

_CAUSES: Final = {
    "model_checksums": "the model",
    "manager_checksum": "the managing system",
    "compute_s": "the nodes' compute times",
    "versions": "the versions",
}
"""Field of a record → its name for messages: the causes for which two runs of one specification may differ."""


def run_again(
    folder: Path,
    into: Path,
    *,
    manager: str | None = None,
    model: str | None = None,
    bag: Path | None = None,
    images: bool = False,
    wanted: Callable[[str], bool] | None = None,
) -> StoredRun:
    """Run a stored run of the simulation again, and make sure that it leaves the same messages.

    The managed system of this process has the extensions of the run.

    Args:
        folder: the record.
        into: the new record's folder, which must not exist, or be empty.
        manager: the managing system, where it is not what the record calls it.
        model: the model, where it is not one of the record's name.
        bag: its bag, where that is not the default flight.
        images: whether the new record keeps images.
        wanted: whether it keeps those of a topic; None for all.

    Raises:
        RecordError: the record is of a live run, or of one that failed, or the messages are others; says why.
        SunsetError: as of `run`.
    """
    stored = read_run(folder)
    if stored.middleware != SIMULATED:
        raise RecordError(
            f"The run in {folder} cannot be run again: it was live, on {stored.middleware}, and only runs of the "
            f"simulation ({SIMULATED}) repeat to the byte."
        )
    if stored.is_empty:
        raise RecordError(f"The run in {folder} cannot be run again: it failed, and left no messages.")
    check_extensions(stored, folder)
    spec = _spec_of(stored, manager, model, bag, images=images)
    resources = prepare(spec)
    if resources.bag_checksum != stored.bag_checksum:
        what = "the default flight of this version" if bag is None else f"the bag {bag}"
        raise RecordError(
            f"The run in {folder} cannot be run again: it was made with other frames than {what} has; name its own bag "
            "with --bag, in Python with bag."
        )
    again = run_prepared(spec, resources, into, wanted=wanted)
    if again.digest != stored.digest:
        causes = ", ".join(_differences(stored, again.record)) or "the record itself"
        where = first_difference(folder, into)
        raise RecordError(
            f"The run in {folder} was run again, and left other messages, {where}; what differs: {causes}. Name what "
            "it was made with, or make a new record."
        )
    return again


def _spec_of(
    stored: RunRecord, manager: str | None, model: str | None, bag: Path | None, *, images: bool
) -> RunSpec:
    """Return the specification of a stored run."""
    timing = {
        name: getattr(stored, name)
        for name in ("duration_s", "warm_up_s", "period_s", "jitter", "latency_s")
        if getattr(stored, name) is not UNSET
    }
    return RunSpec(
        scenario=scenario_of(stored),
        manager=manager or stored.manager_spec or stored.manager,
        label=stored.manager,
        seed=stored.seed,
        settings=Settings(
            model=model or stored.model,
            bag=bag,
            flight=FlightSpec.of(stored.flight_conditions) if stored.flight_conditions else None,
            loop=stored.bag_looped,
            timing=Timing(**timing),
            device=stored.device,
            images=images,
            thinking_s=stored.thinking_s or 0.0,
        ),
    )


def _differences(stored: RunRecord, again: RunRecord) -> Iterator[str]:
    """Yield the differences between two runs that should be identical."""
    for name, what in _CAUSES.items():
        before, now = getattr(stored, name), getattr(again, name)
        if before == now:
            continue
        if name == "versions":
            parts = sorted(part for part in before | now if before.get(part) != now.get(part))
            yield ", ".join(f"{part} {before.get(part, 'none')} is {now.get(part, 'none')}" for part in parts)
        else:
            yield what
