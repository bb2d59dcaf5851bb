"""The parameter services, as real rclpy nodes answer them."""

from pathlib import Path
from typing import Any

import pytest

from conformance.harness import Harness
from sunset_ros.interfaces.diagnostic_msgs.msg import KeyValue
from sunset_ros.interfaces.rcl_interfaces.msg import ParameterEvent, ParameterType
from sunset_ros.interfaces.rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from sunset_ros.parameter import Parameter, parameter_value_to_python

DECLARED = [
    "use_sim_time",
    "flag",
    "topic",
    "numbers",
    "weights",
    "names",
    "image.shift",
    "image.strength",
    "fixed",
    "anything",
    "unset",
]


def get(harness: Harness, *names: str) -> list[Any]:
    client = harness.node.create_client(GetParameters, "/parametrised/get_parameters")
    response = harness.call(client, GetParameters.Request(names=list(names)))
    return [parameter_value_to_python(value) for value in response.values]


def put(harness: Harness, **values: Any) -> list[tuple[bool, str]]:
    client = harness.node.create_client(SetParameters, "/parametrised/set_parameters")
    parameters = [
        Parameter(name.replace("__", "."), value=value).to_parameter_msg() for name, value in values.items()
    ]
    response = harness.call(client, SetParameters.Request(parameters=parameters))
    return [(result.successful, result.reason) for result in response.results]


def test_a_name_of_a_megabyte_is_not_sent_back_whole(harness: Harness) -> None:
    harness.start("Parametrised")
    ((successful, reason),) = put(harness, **{"x" * 2**20: 1})
    assert not successful
    assert "xxx…xxx" in reason
    assert len(reason) <= 2000


def test_values_of_all_kinds_are_got(harness: Harness) -> None:
    harness.start("Parametrised")
    names = ["flag", "topic", "numbers", "weights", "names", "image.strength", "anything"]
    assert get(harness, *names) == [False, "rgb_camera", [1, 2, 3], [0.5, 1.5], ["a", "b"], 0.0, None]


def test_any_undeclared_name_empties_the_answer(harness: Harness) -> None:
    harness.start("Parametrised")
    assert get(harness, "flag", "nonsense") == []
    assert get(harness, "flag", "unset") == []  # declared, but there is no value to get
    types = harness.call(
        harness.node.create_client(GetParameterTypes, "/parametrised/get_parameter_types"),
        GetParameterTypes.Request(names=["flag", "nonsense"]),
    )
    assert list(types.types) == []
    descriptors = harness.call(
        harness.node.create_client(DescribeParameters, "/parametrised/describe_parameters"),
        DescribeParameters.Request(names=["flag", "nonsense"]),
    )
    assert descriptors.descriptors == []


def test_types_are_got(harness: Harness) -> None:
    harness.start("Parametrised")
    client = harness.node.create_client(GetParameterTypes, "/parametrised/get_parameter_types")
    response = harness.call(client, GetParameterTypes.Request(names=["flag", "topic", "numbers", "unset"]))
    assert list(response.types) == [
        ParameterType.PARAMETER_BOOL,
        ParameterType.PARAMETER_STRING,
        ParameterType.PARAMETER_INTEGER_ARRAY,
        ParameterType.PARAMETER_NOT_SET,
    ]


def test_descriptions_tell_range_and_read_only(harness: Harness) -> None:
    harness.start("Parametrised")
    client = harness.node.create_client(DescribeParameters, "/parametrised/describe_parameters")
    response = harness.call(client, DescribeParameters.Request(names=["image.shift", "fixed", "anything"]))
    shift, fixed, anything = response.descriptors
    assert (shift.name, shift.type, shift.description) == ("image.shift", 2, "Shift in pixels")
    assert (shift.integer_range[0].from_value, shift.integer_range[0].to_value) == (0, 100)
    assert fixed.read_only
    assert anything.dynamic_typing


@pytest.mark.parametrize(
    ("prefixes", "depth", "names", "found_prefixes"),
    [
        ([], 0, DECLARED, ["image"]),
        ([], 1, [name for name in DECLARED if "." not in name], []),
        (["image"], 0, ["image.shift", "image.strength"], ["image"]),
        (["image", "flag"], 1, ["flag", "image.shift", "image.strength"], ["image"]),
        (["imag"], 0, [], []),
    ],
)
def test_parameters_are_listed(
    harness: Harness, prefixes: list[str], depth: int, names: list[str], found_prefixes: list[str]
) -> None:
    harness.start("Parametrised")
    client = harness.node.create_client(ListParameters, "/parametrised/list_parameters")
    response = harness.call(client, ListParameters.Request(prefixes=prefixes, depth=depth))
    assert (response.result.names, response.result.prefixes) == (names, found_prefixes)


def test_each_parameter_set_has_its_own_result(harness: Harness) -> None:
    harness.start("Parametrised")
    results = put(harness, flag=True, nonsense=1, topic="forbidden", image__strength=1.5, anything="text")
    assert [successful for successful, _ in results] == [True, False, False, True, True]
    assert "'nonsense' of /parametrised is not declared" in results[1][1]
    assert results[2][1] == "It is forbidden."
    assert get(harness, "flag", "topic", "image.strength", "anything") == [True, "rgb_camera", 1.5, "text"]


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("flag", 1, "Wrong parameter type for flag: expected BOOL, got INTEGER (1)."),
        ("image.strength", 1, "Wrong parameter type for image.strength: expected DOUBLE, got INTEGER (1)."),
        ("image.strength", 2.0, "Parameter image.strength must be from 0 to 1.9, got 2."),
        ("image.strength", float("nan"), "Parameter image.strength must be from 0 to 1.9, got nan."),
        ("image.shift", 101, "Parameter image.shift must be from 0 to 100, got 101."),
        ("image.shift", 15, "Parameter image.shift must be 0 plus a multiple of 10, got 15."),
        ("fixed", 2, "Parameter fixed is read-only."),
        ("unset", 2.0, "Wrong parameter type for unset: expected STRING, got DOUBLE (2.0)."),
    ],
)
def test_a_refusal_gives_its_reason_and_changes_nothing(
    harness: Harness, name: str, value: Any, reason: str
) -> None:
    harness.start("Parametrised")
    before = get(harness, name)
    assert put(harness, **{name.replace(".", "__"): value}) == [(False, reason)]
    assert get(harness, name) == before


def test_atomic_sets_are_all_or_nothing(harness: Harness) -> None:
    harness.start("Parametrised")
    client = harness.node.create_client(SetParametersAtomically, "/parametrised/set_parameters_atomically")

    def put_together(**values: Any) -> bool:
        parameters = [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
        response = harness.call(client, SetParametersAtomically.Request(parameters=parameters))
        return bool(response.result.successful)

    assert not put_together(flag=True, topic="forbidden")
    assert not put_together(flag=True, nonsense=1)
    assert not put_together(flag=True, fixed=2)
    assert get(harness, "flag") == [False]
    assert put_together(flag=True, topic="rgb_enhanced")
    assert get(harness, "flag", "topic") == [True, "rgb_enhanced"]


def test_those_who_ask_for_it_are_told_of_a_set(harness: Harness) -> None:
    harness.start("Parametrised")
    reports = harness.collect(KeyValue, "/parametrised/reports")
    assert harness.spin(lambda: harness.node.count_publishers("/parametrised/reports") == 1)
    harness.pause(0.3)
    put(harness, topic="forbidden", flag=True)
    assert harness.spin(lambda: len(reports) == 1)
    assert reports == [KeyValue(key="flag", value="True")]


def test_each_change_is_an_event(harness: Harness) -> None:
    events = harness.collect(ParameterEvent, "/parameter_events")
    harness.start("Parametrised")
    assert harness.spin(
        harness.node.create_client(SetParameters, "/parametrised/set_parameters").service_is_ready
    )
    harness.pause(0.3)
    events.clear()
    put(harness, flag=True, topic="forbidden", unset="set")
    assert harness.spin(lambda: len(events) == 2)
    assert [event.node for event in events] == ["/parametrised", "/parametrised"]
    assert [parameter.name for parameter in events[0].changed_parameters] == ["flag"]
    assert [parameter.name for parameter in events[1].new_parameters] == ["unset"]


def test_values_come_from_the_command_line(harness: Harness, tmp_path: Path) -> None:
    file = tmp_path / "parameters.yaml"
    file.write_text("/uav/parametrised:\n  ros__parameters:\n    image: {shift: 20}\n    names: [x]\n")
    harness.start(
        "Parametrised",
        "-r",
        "__ns:=/uav",
        "-p",
        "flag:=true",
        "--params-file",
        str(file),
        "-p",
        "anything:=1e-3",
    )
    client = harness.node.create_client(GetParameters, "/uav/parametrised/get_parameters")
    response = harness.call(
        client, GetParameters.Request(names=["flag", "image.shift", "names", "anything", "topic"])
    )
    values = [parameter_value_to_python(value) for value in response.values]
    assert values == [True, 20, ["x"], 0.001, "rgb_camera"]
