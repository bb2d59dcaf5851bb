"""The messages of `system_interfaces`, generated from their definitions."""

from struct import Struct
from types import MappingProxyType
from typing import Self

import numpy as np
import numpy.typing as npt

from sunset_ros.errors import InterfaceError
from sunset_ros.interfaces._codec import *
from sunset_ros.interfaces._message import *
from sunset_ros.interfaces._serialization import *
from sunset_ros.interfaces.builtin_interfaces.msg import Time
from sunset_ros.interfaces.rcl_interfaces.msg import Parameter
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import Header

__all__ = [
    "AdaptationStatus",
    "AdaptationType",
    "Command",
    "Cost",
    "Diagnosis",
    "ExperimentLogging",
    "FaultEnd",
    "FaultInjection",
    "FrameEvaluation",
    "FusionType",
    "ImageDigest",
    "SegmentationMetrics",
    "SensorFusion",
    "SetBlackboardGroup",
    "StrategyStatus",
]

_STRUCT_0 = Struct("<?")
_STRUCT_1 = Struct("<QQdd")
_STRUCT_2 = Struct("<Q")
_STRUCT_3 = Struct("<QBbB?fff")
_STRUCT_4 = Struct("<???")
_STRUCT_5 = Struct("<d")
_STRUCT_6 = Struct("<B")
_STRUCT_7 = Struct("<II")
_STRUCT_8 = Struct("<f")


class AdaptationStatus(Message):
    """system_interfaces/msg/AdaptationStatus."""

    __slots__ = ()
    __ros_name__ = "system_interfaces/msg/AdaptationStatus"
    __ros_fields__ = MappingProxyType({})

    STATUS_NOT_SET = 0
    STATUS_ADAPTATION_TRIGGERED = 1
    STATUS_ADAPTATION_RUNNING = 2
    STATUS_ADAPTATION_FINISHED = 3

    def __init__(self) -> None:
        pass

    def copy(self) -> Self:
        return object.__new__(self.__class__)

    def encode_into(self, out: bytearray) -> None:
        out.append(0)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        return cls(), read_dummy(raw, position)


class AdaptationType(Message):
    """system_interfaces/msg/AdaptationType."""

    __slots__ = ()
    __ros_name__ = "system_interfaces/msg/AdaptationType"
    __ros_fields__ = MappingProxyType({})

    ACTION_NOT_SET = 0
    ACTION_ACTIVATE = 1
    ACTION_DEACTIVATE = 2
    ACTION_RESTART = 3
    ACTION_REDEPLOY = 4
    ACTION_CHANGE_COMMUNICATION = 5
    ACTION_SET_PARAMETER = 6
    ACTION_INCREASE_PARAMETER = 7
    ACTION_DECREASE_PARAMETER = 8
    ACTION_CHANGE_MODE = 9

    def __init__(self) -> None:
        pass

    def copy(self) -> Self:
        return object.__new__(self.__class__)

    def encode_into(self, out: bytearray) -> None:
        out.append(0)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        return cls(), read_dummy(raw, position)


class Command(Message):
    """system_interfaces/msg/Command."""

    __slots__ = ('stamp', 'client', 'service', 'node', 'kind', 'parameters', 'values', 'successful', 'reason')
    __ros_name__ = "system_interfaces/msg/Command"
    __ros_fields__ = MappingProxyType({"stamp": "builtin_interfaces/Time", "client": "string", "service": "string", "node": "string", "kind": "string", "parameters": "string[]", "values": "string[]", "successful": "bool", "reason": "string"})

    stamp: Time
    client: str
    service: str
    node: str
    kind: str
    parameters: list[str]
    values: list[str]
    successful: bool
    reason: str

    def __init__(self, *, stamp: Time | None = None, client: str = "", service: str = "", node: str = "", kind: str = "", parameters: list[str] | None = None, values: list[str] | None = None, successful: bool = False, reason: str = "") -> None:
        self.stamp = Time() if stamp is None else stamp
        self.client = client
        self.service = service
        self.node = node
        self.kind = kind
        self.parameters = [] if parameters is None else parameters
        self.values = [] if values is None else values
        self.successful = successful
        self.reason = reason

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.stamp = copied(self.stamp, Time)
            new.client = self.client
            new.service = self.service
            new.node = self.node
            new.kind = self.kind
            new.parameters = list(self.parameters)
            new.values = list(self.values)
            new.successful = self.successful
            new.reason = self.reason
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Time.encode_into(self.stamp, out)
        write_string(out, self.client)
        write_string(out, self.service)
        write_string(out, self.node)
        write_string(out, self.kind)
        if len(self.parameters) or len(self.values):
            write_size(out, len(self.parameters))
            write_strings(out, self.parameters)
            write_size(out, len(self.values))
            write_strings(out, self.values)
        else:
            out += PAD4[len(out) & 3] + b"\0" * 8
        out += _STRUCT_0.pack(BOOLS[self.successful])
        write_string(out, self.reason)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.stamp, position = Time.decode_from(raw, position)
        new.client, position = read_string(raw, position)
        new.service, position = read_string(raw, position)
        new.node, position = read_string(raw, position)
        new.kind, position = read_string(raw, position)
        position = (position + 3) & -4
        if raw.startswith(b"\0" * 8, position):
            new.parameters = []
            new.values = []
            position += 8
        else:
            size, position = read_size(raw, position)
            new.parameters, position = read_items(raw, position, size, read_string)
            size, position = read_size(raw, position)
            new.values, position = read_items(raw, position, size, read_string)
        (new.successful, ) = _STRUCT_0.unpack_from(raw, position)
        position += 1
        new.reason, position = read_string(raw, position)
        return new, position


class Cost(Message):
    """system_interfaces/msg/Cost."""

    __slots__ = ('stamp', 'model', 'tokens_in', 'tokens_out', 'price', 'think_s')
    __ros_name__ = "system_interfaces/msg/Cost"
    __ros_fields__ = MappingProxyType({"stamp": "builtin_interfaces/Time", "model": "string", "tokens_in": "uint64", "tokens_out": "uint64", "price": "float64", "think_s": "float64"})

    stamp: Time
    model: str
    tokens_in: int
    tokens_out: int
    price: float
    think_s: float

    def __init__(self, *, stamp: Time | None = None, model: str = "", tokens_in: int = 0, tokens_out: int = 0, price: float = 0.0, think_s: float = 0.0) -> None:
        self.stamp = Time() if stamp is None else stamp
        self.model = model
        self.tokens_in = tokens_in
        self.tokens_out = tokens_out
        self.price = price
        self.think_s = think_s

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.stamp = copied(self.stamp, Time)
            new.model = self.model
            new.tokens_in = self.tokens_in
            new.tokens_out = self.tokens_out
            new.price = self.price
            new.think_s = self.think_s
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Time.encode_into(self.stamp, out)
        write_string(out, self.model)
        out += PAD8[len(out) & 7]
        out += _STRUCT_1.pack(self.tokens_in, self.tokens_out, self.price, self.think_s)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.stamp, position = Time.decode_from(raw, position)
        new.model, position = read_string(raw, position)
        position = ((position + 3) & -8) + 4
        (new.tokens_in, new.tokens_out, new.price, new.think_s, ) = _STRUCT_1.unpack_from(raw, position)
        position += 32
        return new, position


class Diagnosis(Message):
    """system_interfaces/msg/Diagnosis."""

    __slots__ = ('stamp', 'faults', 'probabilities')
    __ros_name__ = "system_interfaces/msg/Diagnosis"
    __ros_fields__ = MappingProxyType({"stamp": "builtin_interfaces/Time", "faults": "string[]", "probabilities": "float64[]"})

    stamp: Time
    faults: list[str]
    probabilities: npt.NDArray[np.float64]

    def __init__(self, *, stamp: Time | None = None, faults: list[str] | None = None, probabilities: npt.ArrayLike | None = None) -> None:
        self.stamp = Time() if stamp is None else stamp
        self.faults = [] if faults is None else faults
        self.probabilities = empty(FLOAT64) if probabilities is None else array_of(probabilities, FLOAT64)

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.stamp = copied(self.stamp, Time)
            new.faults = list(self.faults)
            new.probabilities = frozen(self.probabilities, FLOAT64)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Time.encode_into(self.stamp, out)
        if len(self.faults) or len(self.probabilities):
            write_size(out, len(self.faults))
            write_strings(out, self.faults)
            write_array(out, self.probabilities, FLOAT64)
        else:
            out += PAD4[len(out) & 3] + b"\0" * 8

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.stamp, position = Time.decode_from(raw, position)
        position = (position + 3) & -4
        if raw.startswith(b"\0" * 8, position):
            new.faults = []
            new.probabilities = empty(FLOAT64)
            position += 8
        else:
            size, position = read_size(raw, position)
            new.faults, position = read_items(raw, position, size, read_string)
            new.probabilities, position = read_array(raw, position, FLOAT64)
        return new, position


class ExperimentLogging(Message):
    """system_interfaces/msg/ExperimentLogging."""

    __slots__ = ('timestamp', 'scenario', 'source', 'rule_name', 'strategy_name', 'strategy_hash', 'strategy_status', 'adaptation_type', 'adaptation_status', 'success', 'iou', 'vehicle_iou', 'road_iou', 'gt_failure_name', 'is_gt_failure')
    __ros_name__ = "system_interfaces/msg/ExperimentLogging"
    __ros_fields__ = MappingProxyType({"timestamp": "uint64", "scenario": "string", "source": "string", "rule_name": "string", "strategy_name": "string", "strategy_hash": "uint64", "strategy_status": "uint8", "adaptation_type": "int8", "adaptation_status": "uint8", "success": "bool", "iou": "float32", "vehicle_iou": "float32", "road_iou": "float32", "gt_failure_name": "string", "is_gt_failure": "bool"})

    timestamp: int
    scenario: str
    source: str
    rule_name: str
    strategy_name: str
    strategy_hash: int
    strategy_status: int
    adaptation_type: int
    adaptation_status: int
    success: bool
    iou: float
    vehicle_iou: float
    road_iou: float
    gt_failure_name: str
    is_gt_failure: bool

    def __init__(self, *, timestamp: int = 0, scenario: str = "", source: str = "", rule_name: str = "", strategy_name: str = "", strategy_hash: int = 0, strategy_status: int = 0, adaptation_type: int = 0, adaptation_status: int = 0, success: bool = False, iou: float = 0.0, vehicle_iou: float = 0.0, road_iou: float = 0.0, gt_failure_name: str = "", is_gt_failure: bool = False) -> None:
        self.timestamp = timestamp
        self.scenario = scenario
        self.source = source
        self.rule_name = rule_name
        self.strategy_name = strategy_name
        self.strategy_hash = strategy_hash
        self.strategy_status = strategy_status
        self.adaptation_type = adaptation_type
        self.adaptation_status = adaptation_status
        self.success = success
        self.iou = iou
        self.vehicle_iou = vehicle_iou
        self.road_iou = road_iou
        self.gt_failure_name = gt_failure_name
        self.is_gt_failure = is_gt_failure

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.timestamp = self.timestamp
            new.scenario = self.scenario
            new.source = self.source
            new.rule_name = self.rule_name
            new.strategy_name = self.strategy_name
            new.strategy_hash = self.strategy_hash
            new.strategy_status = self.strategy_status
            new.adaptation_type = self.adaptation_type
            new.adaptation_status = self.adaptation_status
            new.success = self.success
            new.iou = self.iou
            new.vehicle_iou = self.vehicle_iou
            new.road_iou = self.road_iou
            new.gt_failure_name = self.gt_failure_name
            new.is_gt_failure = self.is_gt_failure
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        out += PAD8[len(out) & 7]
        out += _STRUCT_2.pack(self.timestamp)
        write_string(out, self.scenario)
        write_string(out, self.source)
        write_string(out, self.rule_name)
        write_string(out, self.strategy_name)
        out += PAD8[len(out) & 7]
        out += _STRUCT_3.pack(self.strategy_hash, self.strategy_status, self.adaptation_type, self.adaptation_status, BOOLS[self.success], self.iou, self.vehicle_iou, self.road_iou)
        write_string(out, self.gt_failure_name)
        out += _STRUCT_0.pack(BOOLS[self.is_gt_failure])

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        position = ((position + 3) & -8) + 4
        (new.timestamp, ) = _STRUCT_2.unpack_from(raw, position)
        position += 8
        new.scenario, position = read_string(raw, position)
        new.source, position = read_string(raw, position)
        new.rule_name, position = read_string(raw, position)
        new.strategy_name, position = read_string(raw, position)
        position = ((position + 3) & -8) + 4
        (new.strategy_hash, new.strategy_status, new.adaptation_type, new.adaptation_status, new.success, new.iou, new.vehicle_iou, new.road_iou, ) = _STRUCT_3.unpack_from(raw, position)
        position += 24
        new.gt_failure_name, position = read_string(raw, position)
        (new.is_gt_failure, ) = _STRUCT_0.unpack_from(raw, position)
        position += 1
        return new, position


class FaultEnd(Message):
    """system_interfaces/msg/FaultEnd."""

    __slots__ = ('stamp', 'fault', 'node', 'healed', 'cause')
    __ros_name__ = "system_interfaces/msg/FaultEnd"
    __ros_fields__ = MappingProxyType({"stamp": "builtin_interfaces/Time", "fault": "string", "node": "string", "healed": "bool", "cause": "string"})

    stamp: Time
    fault: str
    node: str
    healed: bool
    cause: str

    def __init__(self, *, stamp: Time | None = None, fault: str = "", node: str = "", healed: bool = False, cause: str = "") -> None:
        self.stamp = Time() if stamp is None else stamp
        self.fault = fault
        self.node = node
        self.healed = healed
        self.cause = cause

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.stamp = copied(self.stamp, Time)
            new.fault = self.fault
            new.node = self.node
            new.healed = self.healed
            new.cause = self.cause
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Time.encode_into(self.stamp, out)
        write_string(out, self.fault)
        write_string(out, self.node)
        out += _STRUCT_0.pack(BOOLS[self.healed])
        write_string(out, self.cause)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.stamp, position = Time.decode_from(raw, position)
        new.fault, position = read_string(raw, position)
        new.node, position = read_string(raw, position)
        (new.healed, ) = _STRUCT_0.unpack_from(raw, position)
        position += 1
        new.cause, position = read_string(raw, position)
        return new, position


class FaultInjection(Message):
    """system_interfaces/msg/FaultInjection."""

    __slots__ = ('stamp', 'fault', 'failure', 'node', 'parameter', 'value', 'internal', 'redeploy_only', 'confirmed')
    __ros_name__ = "system_interfaces/msg/FaultInjection"
    __ros_fields__ = MappingProxyType({"stamp": "builtin_interfaces/Time", "fault": "string", "failure": "string", "node": "string", "parameter": "string", "value": "string", "internal": "bool", "redeploy_only": "bool", "confirmed": "bool"})

    stamp: Time
    fault: str
    failure: str
    node: str
    parameter: str
    value: str
    internal: bool
    redeploy_only: bool
    confirmed: bool

    def __init__(self, *, stamp: Time | None = None, fault: str = "", failure: str = "", node: str = "", parameter: str = "", value: str = "", internal: bool = False, redeploy_only: bool = False, confirmed: bool = False) -> None:
        self.stamp = Time() if stamp is None else stamp
        self.fault = fault
        self.failure = failure
        self.node = node
        self.parameter = parameter
        self.value = value
        self.internal = internal
        self.redeploy_only = redeploy_only
        self.confirmed = confirmed

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.stamp = copied(self.stamp, Time)
            new.fault = self.fault
            new.failure = self.failure
            new.node = self.node
            new.parameter = self.parameter
            new.value = self.value
            new.internal = self.internal
            new.redeploy_only = self.redeploy_only
            new.confirmed = self.confirmed
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Time.encode_into(self.stamp, out)
        write_string(out, self.fault)
        write_string(out, self.failure)
        write_string(out, self.node)
        write_string(out, self.parameter)
        write_string(out, self.value)
        out += _STRUCT_4.pack(BOOLS[self.internal], BOOLS[self.redeploy_only], BOOLS[self.confirmed])

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.stamp, position = Time.decode_from(raw, position)
        new.fault, position = read_string(raw, position)
        new.failure, position = read_string(raw, position)
        new.node, position = read_string(raw, position)
        new.parameter, position = read_string(raw, position)
        new.value, position = read_string(raw, position)
        (new.internal, new.redeploy_only, new.confirmed, ) = _STRUCT_4.unpack_from(raw, position)
        position += 3
        return new, position


class FrameEvaluation(Message):
    """system_interfaces/msg/FrameEvaluation."""

    __slots__ = ('header', 'iou', 'intersection', 'predicted', 'truth')
    __ros_name__ = "system_interfaces/msg/FrameEvaluation"
    __ros_fields__ = MappingProxyType({"header": "std_msgs/Header", "iou": "float64", "intersection": "uint32[]", "predicted": "uint32[]", "truth": "uint32[]"})

    header: Header
    iou: float
    intersection: npt.NDArray[np.uint32]
    predicted: npt.NDArray[np.uint32]
    truth: npt.NDArray[np.uint32]

    def __init__(self, *, header: Header | None = None, iou: float = 0.0, intersection: npt.ArrayLike | None = None, predicted: npt.ArrayLike | None = None, truth: npt.ArrayLike | None = None) -> None:
        self.header = Header() if header is None else header
        self.iou = iou
        self.intersection = empty(UINT32) if intersection is None else array_of(intersection, UINT32)
        self.predicted = empty(UINT32) if predicted is None else array_of(predicted, UINT32)
        self.truth = empty(UINT32) if truth is None else array_of(truth, UINT32)

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.header = copied(self.header, Header)
            new.iou = self.iou
            new.intersection = frozen(self.intersection, UINT32)
            new.predicted = frozen(self.predicted, UINT32)
            new.truth = frozen(self.truth, UINT32)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Header.encode_into(self.header, out)
        out += PAD8[len(out) & 7]
        out += _STRUCT_5.pack(self.iou)
        if len(self.intersection) or len(self.predicted) or len(self.truth):
            write_array(out, self.intersection, UINT32)
            write_array(out, self.predicted, UINT32)
            write_array(out, self.truth, UINT32)
        else:
            out += PAD4[len(out) & 3] + b"\0" * 12

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.header, position = Header.decode_from(raw, position)
        position = ((position + 3) & -8) + 4
        (new.iou, ) = _STRUCT_5.unpack_from(raw, position)
        position += 8
        position = (position + 3) & -4
        if raw.startswith(b"\0" * 12, position):
            new.intersection = empty(UINT32)
            new.predicted = empty(UINT32)
            new.truth = empty(UINT32)
            position += 12
        else:
            new.intersection, position = read_array(raw, position, UINT32)
            new.predicted, position = read_array(raw, position, UINT32)
            new.truth, position = read_array(raw, position, UINT32)
        return new, position


class FusionType(Message):
    """system_interfaces/msg/FusionType."""

    __slots__ = ('fusion_type',)
    __ros_name__ = "system_interfaces/msg/FusionType"
    __ros_fields__ = MappingProxyType({"fusion_type": "uint8"})

    FUSION = 0
    RGB = 1
    DEPTH = 2

    fusion_type: int

    def __init__(self, *, fusion_type: int = 0) -> None:
        self.fusion_type = fusion_type

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.fusion_type = self.fusion_type
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        out += _STRUCT_6.pack(self.fusion_type)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        (new.fusion_type, ) = _STRUCT_6.unpack_from(raw, position)
        position += 1
        return new, position


class ImageDigest(Message):
    """system_interfaces/msg/ImageDigest."""

    __slots__ = ('header', 'height', 'width', 'encoding', 'digest')
    __ros_name__ = "system_interfaces/msg/ImageDigest"
    __ros_fields__ = MappingProxyType({"header": "std_msgs/Header", "height": "uint32", "width": "uint32", "encoding": "string", "digest": "uint8[]"})

    header: Header
    height: int
    width: int
    encoding: str
    digest: npt.NDArray[np.uint8]

    def __init__(self, *, header: Header | None = None, height: int = 0, width: int = 0, encoding: str = "", digest: npt.ArrayLike | None = None) -> None:
        self.header = Header() if header is None else header
        self.height = height
        self.width = width
        self.encoding = encoding
        self.digest = empty(UINT8) if digest is None else array_of(digest, UINT8)

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.header = copied(self.header, Header)
            new.height = self.height
            new.width = self.width
            new.encoding = self.encoding
            new.digest = frozen(self.digest, UINT8)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Header.encode_into(self.header, out)
        out += PAD4[len(out) & 3]
        out += _STRUCT_7.pack(self.height, self.width)
        write_string(out, self.encoding)
        write_array(out, self.digest, UINT8)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.header, position = Header.decode_from(raw, position)
        position = (position + 3) & -4
        (new.height, new.width, ) = _STRUCT_7.unpack_from(raw, position)
        position += 8
        new.encoding, position = read_string(raw, position)
        new.digest, position = read_array(raw, position, UINT8)
        return new, position


class SegmentationMetrics(Message):
    """system_interfaces/msg/SegmentationMetrics."""

    __slots__ = ('header', 'mean_iou')
    __ros_name__ = "system_interfaces/msg/SegmentationMetrics"
    __ros_fields__ = MappingProxyType({"header": "std_msgs/Header", "mean_iou": "float32"})

    header: Header
    mean_iou: float

    def __init__(self, *, header: Header | None = None, mean_iou: float = 0.0) -> None:
        self.header = Header() if header is None else header
        self.mean_iou = mean_iou

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.header = copied(self.header, Header)
            new.mean_iou = self.mean_iou
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Header.encode_into(self.header, out)
        out += PAD4[len(out) & 3]
        out += _STRUCT_8.pack(self.mean_iou)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.header, position = Header.decode_from(raw, position)
        position = (position + 3) & -4
        (new.mean_iou, ) = _STRUCT_8.unpack_from(raw, position)
        position += 4
        return new, position


class SetBlackboardGroup(Message):
    """system_interfaces/msg/SetBlackboardGroup."""

    __slots__ = ('bb_params',)
    __ros_name__ = "system_interfaces/msg/SetBlackboardGroup"
    __ros_fields__ = MappingProxyType({"bb_params": "rcl_interfaces/Parameter[]"})

    bb_params: list[Parameter]

    def __init__(self, *, bb_params: list[Parameter] | None = None) -> None:
        self.bb_params = [] if bb_params is None else bb_params

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.bb_params = [copied(item, Parameter) for item in self.bb_params]
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        write_size(out, len(self.bb_params))
        write_messages(out, self.bb_params, Parameter)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        size, position = read_size(raw, position)
        new.bb_params, position = read_items(raw, position, size, Parameter.decode_from)
        return new, position


class StrategyStatus(Message):
    """system_interfaces/msg/StrategyStatus."""

    __slots__ = ()
    __ros_name__ = "system_interfaces/msg/StrategyStatus"
    __ros_fields__ = MappingProxyType({})

    STATUS_NOT_SET = 0
    STATUS_STRATEGY_TRIGGERED = 1
    STATUS_STRATEGY_RUNNING = 2
    STATUS_STRATEGY_FINISHED_SUCCESSFUL = 3
    STATUS_STRATEGY_FINISHED_UNSUCCESSFUL = 4
    STATUS_NO_STRATEGY_SUCCESSFUL = 5

    def __init__(self) -> None:
        pass

    def copy(self) -> Self:
        return object.__new__(self.__class__)

    def encode_into(self, out: bytearray) -> None:
        out.append(0)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        return cls(), read_dummy(raw, position)


class SensorFusion(Message):
    """system_interfaces/msg/SensorFusion."""

    __slots__ = ('depth', 'rgb', 'modality', 'header')
    __ros_name__ = "system_interfaces/msg/SensorFusion"
    __ros_fields__ = MappingProxyType({"depth": "sensor_msgs/Image", "rgb": "sensor_msgs/Image", "modality": "system_interfaces/FusionType", "header": "std_msgs/Header"})

    depth: Image
    rgb: Image
    modality: FusionType
    header: Header

    def __init__(self, *, depth: Image | None = None, rgb: Image | None = None, modality: FusionType | None = None, header: Header | None = None) -> None:
        self.depth = Image() if depth is None else depth
        self.rgb = Image() if rgb is None else rgb
        self.modality = FusionType() if modality is None else modality
        self.header = Header() if header is None else header

    def copy(self) -> Self:
        new = object.__new__(self.__class__)
        try:
            new.depth = copied(self.depth, Image)
            new.rgb = copied(self.rgb, Image)
            new.modality = copied(self.modality, FusionType)
            new.header = copied(self.header, Header)
        except (AttributeError, TypeError, InterfaceError) as error:
            raise misfit(self, error) from error
        return new

    def encode_into(self, out: bytearray) -> None:
        Image.encode_into(self.depth, out)
        Image.encode_into(self.rgb, out)
        FusionType.encode_into(self.modality, out)
        Header.encode_into(self.header, out)

    @classmethod
    def decode_from(cls, raw: bytes, position: int) -> tuple[Self, int]:
        new = object.__new__(cls)
        new.depth, position = Image.decode_from(raw, position)
        new.rgb, position = Image.decode_from(raw, position)
        new.modality, position = FusionType.decode_from(raw, position)
        new.header, position = Header.decode_from(raw, position)
        return new, position
