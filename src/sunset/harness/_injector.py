"""Requests to managed nodes that inject a fault, and their outcome."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Final

from sunset.system import FAULT_ACCESS, NAMESPACE, Adaptation, AdaptationKind, current_system, full_name
from sunset_ros.client import AnyClient
from sunset_ros.interfaces import Service
from sunset_ros.interfaces.lifecycle_msgs.msg import Transition
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState, GetState
from sunset_ros.interfaces.rcl_interfaces.srv import SetParameters
from sunset_ros.node import Node
from sunset_ros.parameter import Parameter
from sunset_ros.task import Future

_SERVICES: Final[dict[type[Service], str]] = {
    SetParameters: "set_parameters",
    ChangeState: "change_state",
    GetState: "get_state",
}
_CONFIRMATION_S: Final = 2.0
"""How long a node may take to confirm an injection."""
_TRANSITIONS: Final = {
    AdaptationKind.ACTIVATE: Transition.TRANSITION_ACTIVATE,
    AdaptationKind.DEACTIVATE: Transition.TRANSITION_DEACTIVATE,
}


@dataclass(frozen=True)
class Answer:
    """The outcome of a step."""

    refusal: str = ""
    """Why it was not confirmed; empty if it was."""
    late: bool = False
    """Whether the node did not answer in time."""
    changed: bool = False
    """Whether the step has activated or deactivated a node."""


class Injector:
    """Sets parameters and changes the states of managed nodes, of which `targets` are the names, for the executor."""

    def __init__(self, node: Node, targets: Iterable[str]) -> None:
        self._node = node
        # made before they are needed, so that they are matched by then
        self._clients: dict[tuple[str, type[Service]], AnyClient] = {
            (target, service): node.create_client(service, f"{NAMESPACE}/{target}/{name}")
            for target in targets
            for service, name in _SERVICES.items()
        }

    def apply(self, step: Adaptation, *, access: bool = False) -> Future[Answer]:
        """Do a step of an injection; `access` says whether it changes or ends a fault that is there."""
        outcome: Future[Answer] = Future()

        def finish(answer: Answer) -> None:
            if not outcome.done():
                self._node.destroy_timer(timer)
                outcome.set_result(answer)

        late = Answer(f"{step.node} did not answer within {_CONFIRMATION_S:g} s", late=True)
        timer = self._node.create_timer(_CONFIRMATION_S, lambda: finish(late))
        if step.kind in _TRANSITIONS:
            self._change_state(step, finish)
        else:
            self._set(step, finish, access=access)
        return outcome

    def _set(self, step: Adaptation, finish: Callable[[Answer], None], *, access: bool) -> None:
        names_and_values = [(step.parameter, step.value)]
        is_announced = (full_name(step.node), step.parameter) not in current_system().fault_parameters
        if access or is_announced:
            names_and_values = [(FAULT_ACCESS, True), *names_and_values, (FAULT_ACCESS, False)]
        messages = [Parameter(name, value=value).to_parameter_msg() for name, value in names_and_values]

        def answered(future: Future[SetParameters.Response]) -> None:
            results = (future.result() or SetParameters.Response()).results
            finish(Answer("; ".join(result.reason for result in results if not result.successful)))

        request = SetParameters.Request(parameters=messages)
        self._clients[step.node, SetParameters].call_async(request).add_done_callback(answered)

    def _change_state(self, step: Adaptation, finish: Callable[[Answer], None]) -> None:
        transition = Transition(id=_TRANSITIONS[step.kind], label=str(step.kind))

        def answered(future: Future[ChangeState.Response]) -> None:
            response = future.result()
            if response is not None and response.success:
                finish(Answer(changed=True))
            else:  # it may be so already
                asked = self._clients[step.node, GetState].call_async(GetState.Request())
                asked.add_done_callback(looked_at)

        def looked_at(future: Future[GetState.Response]) -> None:
            response = future.result()
            is_so = response is not None and response.current_state.label == step.kind.goal_state
            finish(Answer("" if is_so else f"{step.node} refused to be {step.kind}d"))

        request = ChangeState.Request(transition=transition)
        self._clients[step.node, ChangeState].call_async(request).add_done_callback(answered)
