"""Messages as text, and back."""

import numpy as np
import pytest
import yaml

from sunset_ros.commands.messages import message_from_yaml, message_to_repr, message_to_yaml
from sunset_ros.errors import InterfaceError, InvalidInputError
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState
from sunset_ros.interfaces.rcl_interfaces.msg import Parameter, ParameterValue
from sunset_ros.interfaces.rcl_interfaces.srv import GetParameters, SetParameters
from sunset_ros.interfaces.sensor_msgs.msg import CameraInfo, Image
from sunset_ros.interfaces.std_msgs.msg import Empty, Float64MultiArray, String
from sunset_ros.interfaces.std_srvs.srv import SetBool


def test_a_message_is_shown_field_by_field() -> None:
    status = DiagnosticStatus(level=b"\x01", name="camera", values=[KeyValue(key="lc_state", value="active")])
    text = message_to_yaml(DiagnosticArray(status=[status]))

    assert text == (
        "header:\n  stamp:\n    sec: 0\n    nanosec: 0\n  frame_id: ''\n"
        "status:\n- level: \"\\x01\"\n  name: camera\n  message: ''\n  hardware_id: ''\n"
        "  values:\n  - key: lc_state\n    value: active\n"
    )


def test_a_message_without_fields_is_an_empty_mapping() -> None:
    assert message_to_yaml(Empty()) == "{}\n"


def test_long_arrays_and_strings_are_cut() -> None:
    image = Image(encoding="x" * 200, data=np.arange(200, dtype=np.uint8))

    cut = yaml.safe_load(message_to_yaml(image))

    assert cut["data"] == [*range(128), "..."]
    assert cut["encoding"] == "x" * 128 + "..."


def test_arrays_can_be_shown_by_type_and_length() -> None:
    image = yaml.safe_load(message_to_yaml(Image(data=np.zeros(7, np.uint8)), arrays=False))
    info = yaml.safe_load(message_to_yaml(CameraInfo(), arrays=False))
    states = yaml.safe_load(message_to_yaml(DiagnosticArray(), arrays=False))

    assert image["data"] == "<sequence type: uint8, length: 7>"
    assert info["k"] == "<array type: double[9]>"
    assert states["status"] == "<sequence type: diagnostic_msgs/msg/DiagnosticStatus, length: 0>"


def test_requests_are_shown_as_python_calls() -> None:
    value = ParameterValue(type=8, double_array_value=np.array([0.5]))
    request = SetParameters.Request(parameters=[Parameter(name="gains", value=value)])

    text = message_to_repr(request)

    assert text.startswith(
        "rcl_interfaces.srv.SetParameters_Request(parameters=[rcl_interfaces.msg.Parameter(name='gains', value="
    )
    assert "double_array_value=[0.5], string_array_value=[])" in text


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("{data: true}", SetBool.Request(data=True)),
        ("", SetBool.Request()),
        ("{}", SetBool.Request()),
        ("names: [a, b]", GetParameters.Request(names=["a", "b"])),
        ("{data: [1, 2.5]}", Float64MultiArray(data=np.array([1, 2.5]))),
        ("{data: []}", Float64MultiArray()),
        ("{data: 'true'}", String(data="true")),
        ("{level: 2}", DiagnosticStatus(level=b"\x02")),
        ("{status: [{name: a}]}", DiagnosticArray(status=[DiagnosticStatus(name="a")])),
    ],
)
def test_yaml_becomes_a_message(text: str, expected: Message) -> None:
    assert message_from_yaml(text, type(expected)) == expected


@pytest.mark.parametrize(
    ("text", "kind", "told"),
    [
        ("{data: 2}", SetBool.Request, "'data' of std_srvs/srv/SetBool_Request must be True or False"),
        ("{dta: true}", SetBool.Request, "no field 'dta'; it has data"),
        ("{3: true}", SetBool.Request, "no field 3"),
        ("[true]", SetBool.Request, "must map the field names"),
        ("{transition: 1}", ChangeState.Request, "Field 'transition' must map"),
        ("{transition: {id: 256}}", ChangeState.Request, "'transition.id' .* from 0 to 255"),
        ("{status: [{values: [1]}]}", DiagnosticArray, r"Field 'status\[0\].values\[0\]' must map"),
        ("{status: {name: a}}", DiagnosticArray, "'status' .* a list"),
        ("{data: [a]}", Float64MultiArray, "'data' .* an array of float64"),
        ("{k: [1, 2]}", CameraInfo, "'k' .* 9 elements"),
        ("{level: 256}", DiagnosticStatus, "'level' .* one byte"),
        ("{a: b}", Empty, "it has no fields"),
    ],
)
def test_values_that_do_not_fit_are_named(text: str, kind: type[Message], told: str) -> None:
    with pytest.raises(InterfaceError, match=told):
        message_from_yaml(text, kind)


@pytest.mark.parametrize(
    "text", ["{data: ", "\x00", "[" * 5000, "!!python/object:os.system {}", "{data: !!bool x}"]
)
def test_what_is_no_yaml_is_refused(text: str) -> None:
    with pytest.raises(InvalidInputError, match="not valid YAML"):
        message_from_yaml(text, String)
