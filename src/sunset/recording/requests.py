"""From recorded commands back to the requests that they were."""

from sunset.system_interfaces.msg import Command
from sunset.system_interfaces.srv import Redeploy
from sunset.texts.names import base_name
from sunset_ros._parameter_files import parse_value
from sunset_ros.interfaces import Message, Service
from sunset_ros.interfaces.lifecycle_msgs.msg import Transition
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState
from sunset_ros.interfaces.rcl_interfaces.srv import SetParameters, SetParametersAtomically
from sunset_ros.interfaces.stamps import ns_of
from sunset_ros.parameter import Parameter


def request_of(command: Command) -> tuple[int, str, type[Service], Message]:
    """Return when a recorded command was served, the service with its type, and the request."""
    time_ns, name = ns_of(command.stamp), command.service
    if command.kind == "redeploy":
        return time_ns, name, Redeploy, Redeploy.Request(node=command.node)
    if command.kind != "set_parameters":
        return time_ns, name, ChangeState, ChangeState.Request(transition=Transition(label=command.kind))
    kind = SetParametersAtomically if base_name(name) == "set_parameters_atomically" else SetParameters
    parameters = [
        Parameter(
            parameter, value=None if text == "unset" else parse_value(text, parameter)
        ).to_parameter_msg()
        for parameter, text in zip(command.parameters, command.values, strict=True)
    ]
    return time_ns, name, kind, kind.Request(parameters=parameters)
