"""Whether a parameter's descriptor admits a value."""

from math import isclose

from sunset_ros.interfaces.rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from sunset_ros.parameter import Parameter


def refusal(parameter: Parameter, descriptor: ParameterDescriptor) -> str | None:
    """Return the reason why a descriptor does not admit a value, or None if it does.

    Whether it is read-only is the caller's to check, since a declaration sets such a parameter once.
    """
    expected = Parameter.Type(descriptor.type)
    if not descriptor.dynamic_typing and parameter.type_ is not expected:
        return (
            f"Wrong parameter type for {parameter.name}: expected {expected.name}, "
            f"got {parameter.type_.name} ({parameter.value!r})."
        )
    if parameter.type_ is Parameter.Type.INTEGER and descriptor.integer_range:
        return _integer_refusal(parameter, descriptor.integer_range[0])
    if parameter.type_ is Parameter.Type.DOUBLE and descriptor.floating_point_range:
        return _double_refusal(parameter, descriptor.floating_point_range[0])
    return None


def _integer_refusal(parameter: Parameter, allowed: IntegerRange) -> str | None:
    value = parameter.value
    low, high = sorted((allowed.from_value, allowed.to_value))
    if not isinstance(value, int) or value in {low, high}:
        return None
    if not low <= value <= high:
        return f"Parameter {parameter.name} must be from {low} to {high}, got {value}."
    if allowed.step and (value - low) % allowed.step:
        return f"Parameter {parameter.name} must be {low} plus a multiple of {allowed.step}, got {value}."
    return None


def _double_refusal(parameter: Parameter, allowed: FloatingPointRange) -> str | None:
    value = parameter.value
    low, high = sorted((allowed.from_value, allowed.to_value))
    if not isinstance(value, float) or isclose(value, low) or isclose(value, high):
        return None
    if not low <= value <= high:  # also when it is not a number
        return f"Parameter {parameter.name} must be from {low:g} to {high:g}, got {value:g}."
    if allowed.step:
        steps = (value - low) / allowed.step
        if not isclose(steps, round(steps), rel_tol=1e-9, abs_tol=1e-9):
            return f"Parameter {parameter.name} must be {low:g} plus a multiple of {allowed.step:g}, got {value:g}."
    return None
