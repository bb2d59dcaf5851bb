from enum import IntEnum

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sunset_ros.exceptions import InvalidParameterTypeException
from sunset_ros.interfaces import deserialize, serialize
from sunset_ros.interfaces.rcl_interfaces.msg import Parameter as ParameterMessage
from sunset_ros.interfaces.rcl_interfaces.msg import ParameterValue
from sunset_ros.parameter import Parameter


class Modality(IntEnum):
    RGB = 1


integers = st.integers(-(2**63), 2**63 - 1)
doubles = st.floats(allow_nan=False)
texts = st.text(st.characters(codec="utf-8", exclude_characters="\0"))
values = st.one_of(
    st.none(),
    st.booleans(),
    integers,
    doubles,
    texts,
    st.lists(st.booleans(), min_size=1),
    st.lists(integers, min_size=1),
    st.lists(doubles, min_size=1),
    st.lists(texts, min_size=1),
    st.lists(st.binary(min_size=1, max_size=1), min_size=1),
)


@given(values)
def test_a_parameter_survives_the_wire(value: object) -> None:
    parameter = Parameter("name", value=value)
    message = deserialize(serialize(parameter.to_parameter_msg()), ParameterMessage)
    assert Parameter.from_parameter_msg(message) == parameter


@pytest.mark.parametrize(
    ("value", "kind"),
    [
        (None, "NOT_SET"),
        (True, "BOOL"),
        (1, "INTEGER"),
        (1.0, "DOUBLE"),
        ("a", "STRING"),
        ([True], "BOOL_ARRAY"),
        ([1], "INTEGER_ARRAY"),
        ((1.0, 2.0), "DOUBLE_ARRAY"),
        (["a"], "STRING_ARRAY"),
        ([b"a"], "BYTE_ARRAY"),
        (np.array([1, 2]), "INTEGER_ARRAY"),
        (np.array([0.5]), "DOUBLE_ARRAY"),
        (np.float64(0.5), "DOUBLE"),
        (Modality.RGB, "INTEGER"),
    ],
)
def test_the_type_follows_from_the_value(value: object, kind: str) -> None:
    assert Parameter("name", value=value).type_ is Parameter.Type[kind]


@pytest.mark.parametrize("value", [{"a": 1}, [1, "a"], [[1]], 1j, object()])
def test_what_a_parameter_cannot_hold_is_refused(value: object) -> None:
    with pytest.raises(InvalidParameterTypeException, match="A parameter cannot hold"):
        Parameter("name", value=value)


def test_a_value_must_be_of_the_type_given() -> None:
    with pytest.raises(
        InvalidParameterTypeException, match="Parameter 'name' must be DOUBLE, got 1, which is INTEGER"
    ):
        Parameter("name", Parameter.Type.DOUBLE, 1)
    with pytest.raises(InvalidParameterTypeException, match=r"must be a Parameter\.Type, got 3"):
        Parameter("name", 3, 1.0)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "kind", ["STRING_ARRAY", "DOUBLE_ARRAY", "BOOL_ARRAY", "INTEGER_ARRAY", "BYTE_ARRAY"]
)
def test_an_empty_list_is_of_any_list_type(kind: str) -> None:
    parameter = Parameter("name", Parameter.Type[kind], [])
    assert Parameter.from_parameter_msg(parameter.to_parameter_msg()) == parameter


def test_an_integer_must_fit() -> None:
    with pytest.raises(InvalidParameterTypeException, match="must fit into 64 bits"):
        Parameter("name", value=2**63)
    with pytest.raises(InvalidParameterTypeException, match="must fit into 64 bits"):
        Parameter("name", value=[1, -(2**63) - 1])


def test_a_value_becomes_one_of_pythons_own_types() -> None:
    values = [
        Parameter("name", value=value).value for value in (Modality.RGB, np.float64(0.5), [Modality.RGB])
    ]
    assert values == [1, 0.5, [1]]
    assert [type(value) for value in values] == [int, float, list]


def test_a_message_of_unknown_type_is_refused() -> None:
    with pytest.raises(InvalidParameterTypeException, match="Parameter type 77 is unknown"):
        Parameter.from_parameter_msg(ParameterMessage(name="name", value=ParameterValue(type=77)))
