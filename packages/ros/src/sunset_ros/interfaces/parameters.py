"""Values of parameters as Python has them."""

from sunset_ros.interfaces.rcl_interfaces.msg import ParameterType, ParameterValue


def scalar_of(value: ParameterValue) -> bool | int | float | str | None:
    """Return the value of a parameter; None for a list, and for an unset value.

    >>> scalar_of(ParameterValue(type=3, double_value=0.5)), scalar_of(ParameterValue(type=9, string_array_value=["a"]))
    (0.5, None)
    """
    match value.type:
        case ParameterType.PARAMETER_BOOL:
            return value.bool_value
        case ParameterType.PARAMETER_INTEGER:
            return value.integer_value
        case ParameterType.PARAMETER_DOUBLE:
            return value.double_value
        case ParameterType.PARAMETER_STRING:
            return value.string_value
        case _:
            return None
