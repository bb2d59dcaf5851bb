"""Parameters as the node itself declares, gets and sets them."""

from typing import TYPE_CHECKING, Any

import pytest

from sunset_ros import CallbackError, Parameter
from sunset_ros.errors import ParameterError
from sunset_ros.exceptions import (
    InvalidParameterException,
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterImmutableException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
)
from sunset_ros.interfaces.rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)

if TYPE_CHECKING:
    from .conftest import World

READ_ONLY = ParameterDescriptor(read_only=True)
DYNAMIC = ParameterDescriptor(dynamic_typing=True)


def test_parameters_are_declared_and_got(world: "World") -> None:
    node = world.node()
    declared = node.declare_parameter("speed", 1.5)
    assert declared == node.get_parameter("speed") == Parameter("speed", value=1.5)
    several = node.declare_parameters("image", [("width", 256), ("name", "rgb", READ_ONLY)])
    assert [parameter.name for parameter in several] == ["image.width", "image.name"]
    assert [parameter.value for parameter in node.get_parameters(["image.width", "speed"])] == [256, 1.5]
    by_prefix = node.get_parameters_by_prefix("image")
    assert {name: parameter.value for name, parameter in by_prefix.items()} == {"width": 256, "name": "rgb"}
    assert node.get_parameter_types(["speed", "image.name"]) == [Parameter.Type.DOUBLE, Parameter.Type.STRING]
    assert node.describe_parameter("image.name").read_only
    assert node.list_parameters(["image"], 0).names == ["image.width", "image.name"]
    assert [descriptor.name for descriptor in node.describe_parameters(["speed"])] == ["speed"]


def test_what_was_not_declared_is_unknown(world: "World") -> None:
    node = world.node()
    assert not node.has_parameter("speed")
    assert node.get_parameter_or("speed", Parameter("speed", value=2.0)).value == 2.0
    assert node.get_parameter_or("speed").type_ is Parameter.Type.NOT_SET
    calls = (
        lambda: node.get_parameter("speed"),
        lambda: node.describe_parameter("speed"),
        lambda: node.get_parameter_type("speed"),
        lambda: node.undeclare_parameter("speed"),
        lambda: node.set_parameters([Parameter("speed", value=1.0)]),
        lambda: node.set_parameters_atomically([Parameter("speed", value=1.0)]),
        lambda: node.set_descriptor("speed", DYNAMIC),
    )
    for call in calls:
        with pytest.raises(
            ParameterNotDeclaredException,
            match=r"Parameter 'speed' of /node is not declared: name one of use_sim_time\.",
        ):
            call()


def test_who_mistypes_a_parameter_is_told_the_nearest(world: "World") -> None:
    node = world.node()
    node.declare_parameter("sharpness_threshold", 0.5)
    with pytest.raises(
        ParameterNotDeclaredException, match=r"did you mean 'sharpness_threshold', or name one"
    ):
        node.set_parameters([Parameter("sharpnes_threshold", value=1.0)])


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        (
            ("use_sim_time", True),
            ParameterAlreadyDeclaredException,
            "'use_sim_time' of /node is declared already",
        ),
        (("", 1), InvalidParameterException, "name must be a text"),
        (("p",), InvalidParameterException, "needs a default value, a type, or dynamic_typing=True"),
        (("p", {"a": 1}), InvalidParameterTypeException, "cannot hold"),
        (
            ("p", 2.0, ParameterDescriptor(floating_point_range=[FloatingPointRange(to_value=1.0)])),
            InvalidParameterValueException,
            "'p' of /node cannot be declared with 2.0: Parameter p must be from 0 to 1, got 2.",
        ),
    ],
)
def test_bad_declarations_are_refused(
    world: "World", arguments: tuple[Any, ...], error: type[Exception], message: str
) -> None:
    node = world.node()
    with pytest.raises(error) as caught:
        node.declare_parameter(*arguments)
    assert message in str(caught.value)
    assert isinstance(caught.value, ParameterError)
    assert not node.has_parameter("p")


@pytest.mark.parametrize("name", ["", None, 3])
def test_wrong_names_are_refused(world: "World", name: object) -> None:
    with pytest.raises(InvalidParameterException, match="name must be a text that is not empty"):
        world.node().declare_parameter(name, 1)  # type: ignore[arg-type]


def test_a_declaration_of_many_must_have_the_right_form(world: "World") -> None:
    with pytest.raises(TypeError, match=r"declared by \(name, value, descriptor\), got \(\)"):
        world.node().declare_parameters("", [()])


def test_overrides_win_over_defaults_unless_ignored(world: "World") -> None:
    arguments = ["--ros-args", "-p", "a:=1", "-p", "b:=1", "-p", "c:=text"]
    node = world.node("node", arguments, parameter_overrides=[Parameter("b", value=2)])
    assert node.declare_parameter("a", 0).value == 1
    assert node.declare_parameter("b", 0).value == 2
    with pytest.raises(InvalidParameterValueException, match="expected INTEGER, got STRING"):
        node.declare_parameter("c", 0)
    assert node.declare_parameter("c", 0, ignore_override=True).value == 0


def test_an_empty_list_from_the_command_line_has_the_declared_type(world: "World") -> None:
    node = world.node("node", ["--ros-args", "-p", "names:=[]"])
    parameter = node.declare_parameter("names", ["a"])
    assert (parameter.type_, parameter.value) == (Parameter.Type.STRING_ARRAY, [])


def test_overrides_can_be_declared_all_at_once(world: "World") -> None:
    node = world.node(
        "node", ["--ros-args", "-p", "a:=1"], automatically_declare_parameters_from_overrides=True
    )
    assert node.get_parameter("a").value == 1


def test_a_read_only_parameter_keeps_its_value(world: "World") -> None:
    node = world.node("node", ["--ros-args", "-p", "fixed:=2"])
    assert node.declare_parameter("fixed", 1, READ_ONLY).value == 2
    (result,) = node.set_parameters([Parameter("fixed", value=3)])
    assert (result.successful, result.reason) == (False, "Parameter fixed is read-only.")
    with pytest.raises(ParameterImmutableException):
        node.undeclare_parameter("fixed")
    with pytest.raises(ParameterImmutableException):
        node.set_descriptor("fixed", DYNAMIC)


def test_a_parameter_may_have_a_type_and_no_value(world: "World") -> None:
    node = world.node()
    node.declare_parameter("name", Parameter.Type.STRING)
    with pytest.raises(ParameterUninitializedException, match="'name' of /node was never set"):
        node.get_parameter("name")
    assert not node.set_parameters([Parameter("name", value=1)])[0].successful
    assert node.set_parameters([Parameter("name", value="x")])[0].successful
    assert node.get_parameter("name").value == "x"


def test_a_parameter_of_dynamic_type_takes_any_value_and_none_undeclares_it(world: "World") -> None:
    node = world.node()
    node.declare_parameter("any", None, DYNAMIC)
    for value in (1, "text", [1.5]):
        assert node.set_parameters([Parameter("any", value=value)])[0].successful
        assert node.get_parameter("any").value == value
    assert node.set_parameters([Parameter("any")])[0].successful
    assert not node.has_parameter("any")


def test_an_undeclared_parameter_is_gone(world: "World") -> None:
    node = world.node()
    node.declare_parameter("speed", 1.0)
    node.undeclare_parameter("speed")
    assert not node.has_parameter("speed")
    assert node.declare_parameter("speed", "fast").value == "fast"


def test_a_node_may_allow_undeclared_parameters(world: "World") -> None:
    node = world.node(allow_undeclared_parameters=True)
    assert node.get_parameter("speed").type_ is Parameter.Type.NOT_SET
    assert node.set_parameters([Parameter("speed", value=1.0)])[0].successful
    assert node.get_parameter("speed").value == 1.0
    assert node.describe_parameter("speed").dynamic_typing
    assert node.describe_parameter("unknown").dynamic_typing


def test_a_new_descriptor_must_admit_the_present_value(world: "World") -> None:
    node = world.node()
    node.declare_parameter("speed", 1.5)
    narrow = ParameterDescriptor(floating_point_range=[FloatingPointRange(to_value=1.0)])
    with pytest.raises(InvalidParameterValueException, match="does not admit the present value"):
        node.set_descriptor("speed", narrow)
    node.set_parameters([Parameter("speed", value=0.5)])
    assert node.set_descriptor("speed", narrow).double_value == 0.5
    assert not node.set_parameters([Parameter("speed", value=1.5)])[0].successful


@pytest.mark.parametrize(
    ("value", "admitted"),
    [
        (0.0, True),
        (0.1, True),
        (0.30000000000000004, True),
        (1.0, True),
        (0.15, False),
        (1.1, False),
        (-0.1, False),
    ],
)
def test_a_range_of_doubles_may_have_steps(world: "World", value: float, admitted: bool) -> None:
    node = world.node()
    steps = ParameterDescriptor(
        floating_point_range=[FloatingPointRange(from_value=1.0, to_value=0.0, step=0.1)]
    )
    node.declare_parameter("share", 0.5, steps)
    assert node.set_parameters([Parameter("share", value=value)])[0].successful is admitted


@pytest.mark.parametrize(
    ("value", "admitted"), [(2, True), (5, True), (8, True), (9, True), (6, False), (1, False), (10, False)]
)
def test_a_range_of_integers_may_have_steps_and_holds_both_ends(
    world: "World", value: int, admitted: bool
) -> None:
    node = world.node()
    allowed = ParameterDescriptor(integer_range=[IntegerRange(from_value=2, to_value=9, step=3)])
    node.declare_parameter("p", 2, allowed)
    assert node.set_parameters([Parameter("p", value=value)])[0].successful is admitted


def test_callbacks_that_are_told_are_told_the_latest_first(world: "World") -> None:
    node = world.node()
    node.declare_parameter("p", 1)
    told: list[str] = []
    node.add_post_set_parameters_callback(lambda _: told.append("first"))
    node.add_post_set_parameters_callback(lambda _: told.append("second"))
    node.set_parameters([Parameter("p", value=2)])
    assert told == ["second", "first"]


def test_callbacks_decide_the_latest_first_and_are_told_afterwards(world: "World") -> None:
    node = world.node()
    node.declare_parameter("speed", 1.0)
    seen: list[tuple[str, Any, Any]] = []

    def decide(name: str, limit: float) -> Any:
        def callback(parameters: list[Parameter]) -> SetParametersResult:
            (parameter,) = parameters
            assert isinstance(parameter.value, float)
            seen.append((name, parameter.value, node.get_parameter("speed").value))
            return SetParametersResult(successful=parameter.value < limit, reason=f"{name} says no")

        return callback

    first, second = decide("first", 5.0), decide("second", 10.0)
    node.add_on_set_parameters_callback(first)
    node.add_on_set_parameters_callback(second)
    node.add_post_set_parameters_callback(
        lambda parameters: seen.append(("post", parameters[0].value, node.get_parameter("speed").value))
    )
    assert node.set_parameters([Parameter("speed", value=2.0)])[0].successful
    assert node.set_parameters([Parameter("speed", value=7.0)])[0].reason == "first says no"
    assert seen == [
        ("second", 2.0, 1.0),
        ("first", 2.0, 1.0),
        ("post", 2.0, 2.0),
        ("second", 7.0, 2.0),
        ("first", 7.0, 2.0),
    ]
    node.remove_on_set_parameters_callback(first)
    assert node.set_parameters([Parameter("speed", value=7.0)])[0].successful
    with pytest.raises(ValueError, match="not in list"):
        node.remove_on_set_parameters_callback(first)


def test_what_a_set_callback_raises_comes_out(world: "World") -> None:
    from sunset_ros.interfaces.rcl_interfaces.srv import SetParameters  # noqa: PLC0415

    node = world.node()
    node.declare_parameter("speed", 1.0)

    def forget_to_return(_: list[Parameter]) -> SetParametersResult:
        return None  # type: ignore[return-value]

    node.add_on_set_parameters_callback(forget_to_return)
    client = world.node("asker").create_client(SetParameters, "/node/set_parameters")
    client.call_async(SetParameters.Request(parameters=[Parameter("speed", value=2.0).to_parameter_msg()]))
    with pytest.raises(CallbackError, match="must return a SetParametersResult, got None"):
        world.pass_time(0.1)
