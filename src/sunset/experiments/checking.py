"""Checks of a managing system: whether it loads, runs, keeps the rules and is deterministic."""

import os
import tempfile
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from sunset.experiments.manager import manager_checksum
from sunset.experiments.resources import prepare_runs
from sunset.experiments.run import run
from sunset.experiments.spec import RunSpec
from sunset.managing import is_registered
from sunset.processes.confinement.walls import confinement_report
from sunset.processes.workers import Progress, Stages, worker_pool
from sunset.recording import read_messages
from sunset.recording.reader import first_difference
from sunset.system import COMMANDS_TOPIC
from sunset.system_interfaces.msg import Command
from sunset.texts.sentences import counted
from sunset_ros.texts import shorten

_HASH_SEED: Final = "PYTHONHASHSEED"
_SHOWN: Final = 3
_LONGEST_REASON: Final = 300


@dataclass(frozen=True, slots=True, kw_only=True)
class ManagerCheck:
    """The verdict on a managing system after two runs with the same seed.

    Attributes:
        manager: its name.
        scenario: the scenario of the runs.
        adaptations: how many it executed.
        refusals: why requests were refused → how often, the most frequent first.
        failure: how it failed, in a sentence; empty if it did not.
        reason: which rule it broke, so that its runs are invalid; empty if none.
        difference: where the runs begin to differ, in words; empty if they do not.
        sets_reordered: whether sets of texts had another order in the second run. A class that only this process has,
            such as a class of a notebook, cannot be run in another interpreter.
    """

    manager: str
    scenario: str
    adaptations: int
    refusals: Mapping[str, int]
    failure: str
    reason: str
    difference: str
    sets_reordered: bool

    @property
    def deterministic(self) -> bool:
        """Whether both runs left the same messages."""
        return not self.difference

    @property
    def passed(self) -> bool:
        """Whether it does not fail, keeps the rules and is deterministic."""
        return not self.failure and not self.reason and self.deterministic

    def __str__(self) -> str:
        """Return the verdict as a table of text."""
        same = "yes" if self.deterministic else f"no: the same seed gave different records, {self.difference}"
        done = f"{counted(self.adaptations, 'adaptation')} in {self.scenario}"
        where = "" if self.sets_reordered else " (sets kept their order: the class is of this process only)"
        return "\n".join(
            (
                f"loads            yes: {self.manager}",
                f"runs             {f'no: {self.failure}' if self.failure else f'yes: {done}'}",
                *self._refused(),
                f"keeps the rules  {f'no: {self.reason}' if self.reason else 'yes'}",
                f"deterministic    {same}{where}",
                f"walls            {'none: the class is of this process only' if where else confinement_report()}",
            )
        )

    def _refused(self) -> Iterator[str]:
        if self.refusals:
            is_plural = len(self.refusals) > 1
            reasons = [
                shorten(reason.rstrip("."), _LONGEST_REASON)
                + (f" ({counted(times, 'time')})" if is_plural else "")
                for reason, times in self.refusals.items()
            ]
            more = [f"and {counted(len(reasons) - _SHOWN, 'other reason')}"] if len(reasons) > _SHOWN else []
            number = counted(sum(self.refusals.values()), "request")
            yield f"refused          {number}: {'; '.join([*reasons[:_SHOWN], *more])}"


def check_manager(
    spec: RunSpec, *, progress: Progress | None = None, preparing: Stages | None = None
) -> ManagerCheck:
    """Run it twice with the same seed, in interpreters in which sets of texts have different orders, and compare."""
    manager_checksum(spec.manager, spec.settings)  # a mistake in it is reported at once
    prepare_runs([spec], preparing)
    is_own, results = is_registered(spec.manager), []
    show = progress or (lambda _done, _all: None)
    with tempfile.TemporaryDirectory(prefix="sunset-") as name:
        folders = [Path(name) / "1", Path(name) / "2"]
        for done, folder in enumerate(folders):
            show(done, 2)
            if is_own:
                results.append(run(spec, folder, log=not done))
                continue
            with _hash_seed(folder.name), worker_pool(1) as pool:
                results.append(pool.submit(run, spec, folder, log=not done).result())
        difference = first_difference(*folders)
        messages = [recorded.message for recorded in read_messages(folders[0], [COMMANDS_TOPIC])]
        show(2, 2)
    commands = [message for message in messages if isinstance(message, Command)]
    refusals = Counter(command.reason for command in commands if not command.successful)
    return ManagerCheck(
        manager=spec.manager_name,
        scenario=spec.scenario.name,
        adaptations=results[0].metrics.adaptations,
        refusals=dict(refusals.most_common()),
        failure=results[0].record.manager_failed or "",
        reason=results[0].reason,
        difference=difference,
        sets_reordered=not is_own,
    )


@contextmanager
def _hash_seed(value: str) -> Iterator[None]:
    own = os.environ.get(_HASH_SEED)
    os.environ[_HASH_SEED] = value
    try:
        yield
    finally:
        del os.environ[_HASH_SEED]
        if own is not None:
            os.environ[_HASH_SEED] = own
