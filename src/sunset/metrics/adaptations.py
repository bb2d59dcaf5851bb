"""The adaptations of the managed system, from the commands that reached it."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

from sunset.metrics.timeline import TOLERANCE_S, Command, Injection
from sunset.system import INFRASTRUCTURE, current_system, short_name

_RESTART_S = 1.0  # at most from deactivate to activate
_KINDS = {
    **{kind: kind for kind in ("activate", "deactivate", "configure", "cleanup", "redeploy")},
    "shutdown": "redeploy",
    "set_parameters": "set_parameter",
}
_BETWEEN = ("cleanup", "configure")  # lifecycle steps that may lie within a restart
_FRACTION = re.compile(r"-?\d+\.\d+(e[+-]\d+)?")


@dataclass(frozen=True, slots=True)
class ExecutedAdaptation:
    """An adaptation that was carried out.

    Attributes:
        time: when its command was received, for a restart the first [s].
        node: without namespace.
        kind: `restart`, `redeploy`, `activate`, `deactivate`, `configure`, `cleanup`, `set_parameter` or
            `change_topic`.
        client: the full name of the node that requested it.
        values: of the parameters that were set, as text.
        begun: when the shutdown before a redeploy was received [s].
        completed: when the activation of a restart was received [s].
    """

    time: float
    node: str
    kind: str
    client: str = ""
    parameters: tuple[str, ...] = ()
    values: tuple[str, ...] = ()
    begun: float | None = None
    completed: float | None = None

    @property
    def moments(self) -> tuple[float, ...]:
        """When its first and last commands came [s]."""
        return tuple(time for time in (self.begun, self.time, self.completed) if time is not None)

    def __str__(self) -> str:
        """Return it in words, such as `set sensor_fusion.modality to 1` or `restart camera`."""
        first, *others = self.steps
        return " and ".join([first, *(step.removeprefix("set ") for step in others)])

    @property
    def parts(self) -> "tuple[ExecutedAdaptation, ...]":
        """An adaptation for each parameter that the call sets; any other adaptation itself."""
        pairs = zip(self.parameters, self.values, strict=True)
        return tuple(replace(self, parameters=(name,), values=(value,)) for name, value in pairs) or (self,)

    @property
    def steps(self) -> tuple[str, ...]:
        """Each parameter that it sets in words; for another adaptation, the adaptation in words."""
        if not self.parameters:
            return (f"{self.kind} {self.node}",)
        pairs = zip(self.parameters, self.values, strict=True)
        return tuple(f"set {self.node}.{name} to {_short(value)}" for name, value in pairs)


def _short(value: str) -> str:
    """Return a value's text with at most 6 significant digits.

    >>> _short("0.25322999999999996"), _short("300.0"), _short("rgb_camera")
    ('0.25323', '300.0', 'rgb_camera')
    """
    if not _FRACTION.fullmatch(value):
        return value
    rounded = f"{float(value):.6g}"
    return value if float(rounded) == float(value) else rounded


def affects(node: str, failure: str) -> bool:
    """Return whether an adaptation of `node` can resolve `failure`, as it is the failing node or upstream of it.

    >>> affects("depth", "F2"), affects("depth", "F1")
    (True, False)
    """
    system = current_system()
    failing = system.failing_nodes[failure]
    return node == failing or node in system.upstream[failing]


def executed_adaptations(commands: Sequence[Command], *, until_s: float) -> tuple[ExecutedAdaptation, ...]:
    """Return the adaptations that the commands perform, in order of time.

    - Successful commands to managed nodes up to `until_s` count, also in the warm-up, unless the experiment's own nodes
      sent them.
    - A call that sets parameters is a single adaptation: a change of topic if a parameter names the topic of an input.
    - A deactivation and an activation of a node by the same client within 1 s are a restart, together with a cleanup
      and a configuration between them.
    - A lifecycle shutdown is a redeploy; with the launcher's redeploy after it, it is a single adaptation, at the time
      of the second.

    Args:
        commands: in order of time.
        until_s: the end of the experiment.
    """
    done: list[ExecutedAdaptation] = []
    shut_down: dict[str, ExecutedAdaptation] = {}
    for command in commands:
        adaptation = _adaptation(command)
        if adaptation is None or adaptation.time > until_s:
            continue
        if command.kind == "shutdown":
            shut_down[adaptation.node] = adaptation
        elif command.kind == "redeploy" and adaptation.node in shut_down:
            shutdown = shut_down.pop(adaptation.node)
            done.remove(shutdown)
            adaptation = replace(adaptation, begun=shutdown.time)
        _append(done, adaptation)
    return tuple(done)


def _adaptation(command: Command) -> ExecutedAdaptation | None:
    """Return the adaptation of a command, or None if it does not count."""
    system = current_system()
    node = short_name(command.node)
    kind = _KINDS.get(command.kind)
    if not command.successful or command.client in INFRASTRUCTURE or node not in system.nodes or kind is None:
        return None
    if any((node, name) in system.topic_parameters for name in command.parameters):
        kind = "change_topic"
    return ExecutedAdaptation(command.time, node, kind, command.client, command.parameters, command.values)


def _append(done: list[ExecutedAdaptation], new: ExecutedAdaptation) -> None:
    """Append `new`, or merge it with the deactivation that it completes into a restart."""
    steps: list[ExecutedAdaptation] = []
    for old in reversed(done if new.kind == "activate" else []):
        if new.time - old.time > _RESTART_S + TOLERANCE_S:
            break
        if (old.node, old.client) != (new.node, new.client) or old.parameters:
            continue
        if old.kind == "deactivate":
            done[done.index(old)] = replace(old, kind="restart", completed=new.time)
            for step in steps:
                done.remove(step)
            return
        if old.kind not in _BETWEEN:
            break
        steps.append(old)
    done.append(new)


def unnecessary_redeploys(
    adaptations: Sequence[ExecutedAdaptation], injections: Sequence[Injection]
) -> tuple[ExecutedAdaptation, ...]:
    """Return the redeploys of a node without a present fault that only a redeploy cures.

    Such a fault is present from its injection to the first redeploy of its node, or until it heals. Both arguments are
    in order of time.

    Source: the paper, section 4, on unnecessary redeploys.
    """
    open_faults = [injection for injection in injections if injection.redeploy_only]
    unnecessary = []
    for redeploy in (adaptation for adaptation in adaptations if adaptation.kind == "redeploy"):
        cured = [
            fault
            for fault in open_faults
            if short_name(fault.node) == redeploy.node
            and fault.time <= redeploy.time
            and (fault.healed is None or fault.over is None or min(redeploy.moments) < fault.over)
        ]
        open_faults = [fault for fault in open_faults if fault not in cured]
        if not cured:
            unnecessary.append(redeploy)
    return tuple(unnecessary)
