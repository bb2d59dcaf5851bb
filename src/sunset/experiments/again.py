"""Run a stored run again and check that its messages are the same, or play its commands back for its images."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

from msgspec import UNSET

from sunset.errors import RecordError
from sunset.experiments.resources import Resources, prepare
from sunset.experiments.run import run_prepared
from sunset.experiments.spec import RunSpec, Settings, Timing
from sunset.experiments.stored_faults import scenario_of
from sunset.flights import FlightSpec
from sunset.interfaces.system_interfaces.msg import Command
from sunset.managing import MANAGERS, checksum, is_registered
from sunset.recording import RunRecord, StoredRun, image_digests, read_messages, read_run
from sunset.recording.reader import check_extensions, first_difference
from sunset.rmw.backends import SIMULATED
from sunset.texts import shown

_CAUSES: Final = {
    "model_checksums": "the model",
    "manager_checksum": "the managing system",
    "manager_versions": "what it imported",
    "compute_s": "the nodes' compute times",
    "versions": "the versions",
}
"""Field of a record → its name for messages: the causes for which two runs of one specification may differ."""


def run_again(
    folder: Path,
    into: Path,
    *,
    manager: str | None = None,
    trust: bool = False,
    model: str | None = None,
    bag: Path | None = None,
    images: bool = False,
) -> StoredRun:
    """Run a stored run of the simulation again, and make sure that it leaves the same messages.

    The managed system of this process has the extensions of the run.

    Args:
        folder: the record.
        into: the new record's folder, which must not exist, or be empty.
        manager: the managing system, where it is not what the record calls it.
        trust: whether the code that the record calls its managing system may run.
        model: the model, where it is not one of the record's name.
        bag: its bag, where that is not the default flight.
        images: whether the new record keeps images.

    Raises:
        RecordError: the record is of a live run, or of one that failed, or names code that is not trusted, or the
            managing system or the messages are others; says why.
        SunsetError: as of `run`.
    """
    stored = read_run(folder)
    name = stored.manager_spec or stored.manager
    is_code = name not in MANAGERS and not is_registered(name)  # a class that was passed is the user's own
    if is_code and manager is None and not trust:
        raise RecordError(
            f"The run in {folder} was made with the managing system {shown(name)}, which is code that the record "
            "names: read it, and say trust=True, or name it with manager."
        )
    spec, resources = _prepared(folder, stored, manager or name, model, bag, images=images)
    known = "" if is_registered(spec.manager) or not is_code else stored.manager_checksum
    if known and known != checksum(spec.manager):
        raise RecordError(
            f"The run in {folder} was made with other source than {shown(spec.manager)} has now: restore it, or say "
            "with manager where it is."
        )
    again = run_prepared(spec, resources, into)
    if again.digest != stored.digest:
        causes = ", ".join(_differences(stored, again.record)) or "the record itself"
        where = first_difference(folder, into)
        raise RecordError(
            f"The run in {folder} was run again, and left other messages, {where}; what differs: {causes}. Name what "
            "it was made with, or make a new record."
        )
    return again


def play_back(
    folder: Path,
    into: Path,
    *,
    model: str | None = None,
    bag: Path | None = None,
    wanted: Callable[[str], bool] | None = None,
) -> int:
    """Make the images of a stored run of the simulation by its commands, without its managing system.

    Args:
        folder: the record.
        into: the folder for a record with the images, which must not exist, or be empty.
        model: the model, where it is not one of the record's name.
        bag: its bag, where that is not the default flight.
        wanted: whether it keeps those of a topic; None for all.

    Returns:
        How many images differ from those of the run.

    Raises:
        RecordError: the run was live, or it failed.
        SunsetError: as of `run`.
    """
    stored = read_run(folder)
    spec, resources = _prepared(folder, stored, "none", model, bag, images=True)
    messages = read_messages(folder)
    commands = [one.message for one in messages if isinstance(one.message, Command)]
    played = [one for one in commands if one.successful or one.kind != "set_parameters"]
    run_prepared(spec, resources, into, wanted=wanted, played=played)
    return len(image_digests(messages) - image_digests(read_messages(into)))


def _prepared(
    folder: Path, stored: RunRecord, manager: str, model: str | None, bag: Path | None, *, images: bool
) -> tuple[RunSpec, Resources]:
    """Return the specification of a stored run, with another managing system, and what it is made with.

    Raises:
        RecordError: it was live, it failed, or its flight is another one.
    """
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
    return spec, resources


def _spec_of(
    stored: RunRecord, manager: str, model: str | None, bag: Path | None, *, images: bool
) -> RunSpec:
    """Return the specification of a stored run."""
    timing = {
        name: getattr(stored, name)
        for name in ("duration_s", "warm_up_s", "period_s", "jitter", "latency_s")
        if getattr(stored, name) is not UNSET
    }
    return RunSpec(
        scenario=scenario_of(stored),
        manager=manager,
        label=stored.manager,
        seed=stored.seed,
        suite_size=stored.suite_size or 0,
        settings=Settings(
            model=model or stored.model,
            bag=bag,
            flight=FlightSpec.of(stored.flight_conditions) if stored.flight_conditions else None,
            loop=stored.bag_looped,
            timing=Timing(**timing),
            device=stored.device,
            images=images,
            task=stored.task,
            thinking_s=stored.thinking_s or 0.0,
        ),
    )


def _differences(stored: RunRecord, again: RunRecord) -> Iterator[str]:
    """Yield the differences between two runs that should be identical."""
    for name, what in _CAUSES.items():
        before, now = getattr(stored, name), getattr(again, name)
        if before == now:
            continue
        if name.endswith("versions"):
            before, now = before or {}, now or {}
            parts = sorted(part for part in before | now if before.get(part) != now.get(part))
            yield ", ".join(f"{part} {before.get(part, 'none')} is {now.get(part, 'none')}" for part in parts)
        else:
            yield what
