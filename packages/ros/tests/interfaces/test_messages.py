import copy
import pickle

import numpy as np
import pytest

from sunset_ros.errors import InterfaceError
from sunset_ros.interfaces import Message, field_types, serialize, type_name
from sunset_ros.interfaces.builtin_interfaces.msg import Time
from sunset_ros.interfaces.diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from sunset_ros.interfaces.lifecycle_msgs.msg import State, Transition
from sunset_ros.interfaces.rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from sunset_ros.interfaces.rcl_interfaces.srv import ListParameters, SetParameters
from sunset_ros.interfaces.rmw_dds_common.msg import Gid, ParticipantEntitiesInfo
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import Header, String

DEFAULTS = {"bool": False, "byte": b"\0", "string": "", "float32": 0.0, "float64": 0.0}
OWN_DEFAULTS = {
    ("geometry_msgs/msg/Quaternion", "w"): 1.0,
}


def test_fields_default_to_zero_empty_and_false(kind: type[Message]) -> None:
    message = kind()
    for name, field in field_types(kind).items():
        value = getattr(message, name)
        if field.is_array:
            assert len(value) == (field.size or 0)
            assert not any(np.atleast_1d(value).tolist())
            assert isinstance(value, np.ndarray if field.is_numpy else list)
        elif field.is_message:
            assert value.__ros_name__ == field.base
        else:
            assert value == OWN_DEFAULTS.get((type_name(kind), name), DEFAULTS.get(field.base, 0))
            assert type(value) is type(DEFAULTS.get(field.base, 0))


def test_a_copy_equals_its_original(examples: list[Message]) -> None:
    for message in examples:
        assert message.copy() == message
        assert type(message.copy()) is type(message)


def test_a_pickled_or_deep_copied_message_equals_its_original(examples: list[Message]) -> None:
    for message in examples:
        assert pickle.loads(pickle.dumps(message)) == message  # noqa: S301  our own bytes
        assert copy.deepcopy(message) == message


def test_numeric_arrays_have_the_exact_type() -> None:
    values = ([1, 2], (3,), np.array([4], np.uint8))
    arrays = [ParameterValue(integer_array_value=value).integer_array_value for value in values]
    assert [array.dtype for array in arrays] == [np.int64] * 3
    assert Image(data=b"ab").data.tolist() == [97, 98]
    assert Image().data.dtype == np.uint8


def test_an_array_of_the_right_type_is_not_copied() -> None:
    pixels = np.zeros(12, np.uint8)
    assert Image(data=pixels).data is pixels


def test_a_copy_shares_arrays_and_makes_them_read_only() -> None:
    image = Image(data=np.zeros(12, np.uint8))
    twin = image.copy()
    assert twin.data is image.data
    with pytest.raises(ValueError, match="read-only"):
        image.data[0] = 1


def test_a_copy_shares_no_message_and_no_list() -> None:
    array = DiagnosticArray(status=[DiagnosticStatus(name="a", values=[KeyValue(key="k")])])
    twin = array.copy()
    array.header.stamp.sec = 5
    array.status[0].values[0].key = "other"
    array.status.append(DiagnosticStatus())
    assert twin == DiagnosticArray(status=[DiagnosticStatus(name="a", values=[KeyValue(key="k")])])


def test_a_copy_turns_sequences_into_what_the_definition_says() -> None:
    value = ParameterValue()
    value.double_array_value = [1, 2]  # type: ignore[assignment]
    value.string_array_value = ("a",)  # type: ignore[assignment]
    twin = value.copy()
    assert isinstance(twin.double_array_value, np.ndarray)
    assert twin.string_array_value == ["a"]


def test_copying_what_does_not_fit_names_the_field() -> None:
    info = ParticipantEntitiesInfo()
    info.gid.data = np.zeros((2, 2), np.uint8)
    with pytest.raises(
        InterfaceError, match=r"Field 'gid\.data' of rmw_dds_common/msg/ParticipantEntitiesInfo"
    ):
        info.copy()
    info.gid = None  # type: ignore[assignment]
    with pytest.raises(InterfaceError, match=r"Field 'gid' of .* must be a rmw_dds_common/msg/Gid, got None"):
        info.copy()


def test_the_constructor_refuses_an_array_that_does_not_fit() -> None:
    with pytest.raises(InterfaceError, match="from 0 to 255"):
        Image(data=[300])


def test_the_constructor_takes_keywords_of_its_fields_only() -> None:
    with pytest.raises(TypeError, match="unexpected keyword"):
        String(text="a")  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="positional"):
        String("a")  # type: ignore[call-arg]


def test_an_unknown_field_cannot_be_assigned() -> None:
    with pytest.raises(AttributeError, match="dat"):
        String().dat = "a"  # type: ignore[attr-defined]


def test_messages_are_compared_by_value() -> None:
    assert Image(data=[1, 2]) == Image(data=[1, 2])
    assert Image(data=[1, 2]) != Image(data=[1, 3])
    assert Image(data=[1, 2]) != Image(data=[1])
    assert Header(stamp=Time(sec=1)) != Header(stamp=Time(sec=2))
    assert Parameter(name="a") != Parameter(name="b")
    assert State() != Transition()
    assert String() != "a"


def test_messages_have_no_hash() -> None:
    with pytest.raises(TypeError, match="unhashable"):
        hash(String())


def test_defaults_are_not_shared_between_messages() -> None:
    first, second = SetParameters.Request(), SetParameters.Request()
    first.parameters.append(Parameter())
    assert second.parameters == []
    Gid().data[0] = 1
    assert Gid().data[0] == 0


def test_constants_are_class_attributes() -> None:
    assert DiagnosticStatus.ERROR == b"\x02"
    assert State.PRIMARY_STATE_ACTIVE == 3
    assert Transition.TRANSITION_ACTIVE_SHUTDOWN == 7
    assert ParameterType.PARAMETER_STRING_ARRAY == 9
    assert ListParameters.Request.DEPTH_RECURSIVE == 0


def test_a_representation_names_every_field_and_abbreviates_long_arrays() -> None:
    assert repr(Header(frame_id="a")) == "Header(stamp=Time(sec=0, nanosec=0), frame_id='a')"
    assert "data=<12 uint8>" in repr(Image(data=bytes(12)))
    assert "data=[1, 2]" in repr(Image(data=[1, 2]))


def test_serializing_leaves_arrays_writable() -> None:
    image = Image(data=np.zeros(4, np.uint8))
    serialize(image)
    image.data[0] = 1
    assert image.data[0] == 1
