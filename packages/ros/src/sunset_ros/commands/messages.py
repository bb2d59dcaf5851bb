"""Messages as text, and back, in the forms that the `ros2` command line has for them."""

import sys
from dataclasses import replace
from typing import Final

import numpy as np
import yaml

from sunset_ros.errors import MALFORMED_YAML, InterfaceError, InvalidInputError
from sunset_ros.interfaces import FieldType, Message, field_types, get_message, serialize, type_name

_SHOWN: Final = 128
"""The most elements of a sequence, and characters of a string, that are shown."""

_IDL_NAMES: Final = {"float64": "double", "float32": "float", "bool": "boolean", "byte": "octet"}


def message_to_yaml(message: Message, *, arrays: bool = True) -> str:
    r"""Return a message as `ros2 topic echo` prints it; without `arrays`, they are shown by their type and length.

    >>> from sunset_ros.interfaces.std_msgs.msg import Header
    >>> message_to_yaml(Header(frame_id="camera"))
    'stamp:\n  sec: 0\n  nanosec: 0\nframe_id: camera\n'
    """
    plain = _plain_message(message, arrays)
    return yaml.safe_dump(
        plain, allow_unicode=True, width=sys.maxsize, sort_keys=False, default_flow_style=False
    )


def _plain_message(message: Message, arrays: bool) -> dict[str, object]:
    fields = field_types(type(message))
    return {name: _plain(kind, getattr(message, name), arrays) for name, kind in fields.items()}


def _plain(kind: FieldType, value: object, arrays: bool) -> object:
    if isinstance(value, Message):
        return _plain_message(value, arrays)
    if isinstance(value, bytes):  # a single byte
        return value.decode("latin-1")
    if isinstance(value, str):
        return value if len(value) <= _SHOWN else f"{value[:_SHOWN]}..."
    if not isinstance(value, list | np.ndarray):
        return value
    if not arrays:
        return _abbreviated(kind, len(value))
    shown = value[:_SHOWN]
    items = shown.tolist() if isinstance(shown, np.ndarray) else shown
    plain = [_plain(kind, item, arrays) for item in items]
    return plain if len(value) <= _SHOWN else [*plain, "..."]


def _abbreviated(kind: FieldType, length: int) -> str:
    element = _IDL_NAMES.get(kind.base, kind.base)
    if kind.size is not None:
        return f"<array type: {element}[{kind.size}]>"
    if kind.limit is not None:
        return f"<bounded sequence type: {element}[{kind.limit}], length: {length}>"
    return f"<sequence type: {element}, length: {length}>"


def message_to_repr(message: Message) -> str:
    """Return a message as `ros2 service call` prints requests and responses.

    >>> from sunset_ros.interfaces.std_srvs.srv import SetBool
    >>> message_to_repr(SetBool.Request(data=True))
    'std_srvs.srv.SetBool_Request(data=True)'
    """
    fields = ", ".join(f"{name}={_repr(getattr(message, name))}" for name in field_types(type(message)))
    return f"{type_name(type(message)).replace('/', '.')}({fields})"


def _repr(value: object) -> str:
    if isinstance(value, Message):
        return message_to_repr(value)
    if isinstance(value, np.ndarray):
        return repr(value.tolist())
    if isinstance(value, list):
        return f"[{', '.join(_repr(item) for item in value)}]"
    return repr(value)


def message_from_yaml(text: str, kind: type[Message]) -> Message:
    """Return the message of a class whose fields a YAML mapping gives; all others keep their defaults.

    >>> from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState
    >>> message_from_yaml("{transition: {label: configure}}", ChangeState.Request)
    Request(transition=Transition(id=0, label='configure'))
    """
    try:
        values = yaml.safe_load(text)
    except yaml.MarkedYAMLError as error:
        raise InvalidInputError(f"The values {text!r} are not valid YAML: {error.problem}.") from error
    except (yaml.YAMLError, *MALFORMED_YAML) as error:
        raise InvalidInputError(f"The values {text!r} are not valid YAML: {error}.") from error
    message = _message({} if values is None else values, kind, "")
    serialize(message)  # names the field that does not fit
    return message


def _message(values: object, kind: type[Message], path: str) -> Message:
    if not isinstance(values, dict):
        where = f"Field {path!r}" if path else "The message"
        raise InterfaceError(
            f"{where} must map the field names of {type_name(kind)} to values, got {values!r}."
        )
    message, fields = kind(), field_types(kind)
    for name, value in values.items():
        if name not in fields:
            known = ", ".join(fields) or "no fields"
            raise InterfaceError(f"{type_name(kind)} has no field {name!r}; it has {known}.")
        here = f"{path}.{name}" if path else name
        setattr(message, name, _value(fields[name], value, here))
    return message


def _value(kind: FieldType, value: object, path: str) -> object:
    """Return a field's value; a value that does not fit is returned as it is, for `serialize` to name it."""
    if kind.is_array:
        if not isinstance(value, list) or kind.is_numpy:
            return value
        element = replace(kind, is_array=False)
        return [_value(element, item, f"{path}[{index}]") for index, item in enumerate(value)]
    if kind.is_message:
        return _message(value, get_message(kind.base), path)
    if kind.base == "byte" and isinstance(value, int) and value in range(256):
        return bytes([value])
    return value
