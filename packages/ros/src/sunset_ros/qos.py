"""Quality of service profiles, as in `rclpy.qos`; deadline and liveliness are not supported."""

from typing import Final

from sunset_ros.errors import MiddlewareError
from sunset_ros.rmw.core.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

__all__ = [
    "DurabilityPolicy",
    "HistoryPolicy",
    "QoSDurabilityPolicy",
    "QoSHistoryPolicy",
    "QoSProfile",
    "QoSReliabilityPolicy",
    "ReliabilityPolicy",
    "qos_profile_parameter_events",
    "qos_profile_parameters",
    "qos_profile_rosout_default",
    "qos_profile_sensor_data",
    "qos_profile_services_default",
    "qos_profile_system_default",
    "to_profile",
]

QoSHistoryPolicy = HistoryPolicy
QoSReliabilityPolicy = ReliabilityPolicy
QoSDurabilityPolicy = DurabilityPolicy

qos_profile_system_default: Final = QoSProfile(depth=10)
qos_profile_services_default: Final = QoSProfile(depth=10)
qos_profile_sensor_data: Final = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
qos_profile_parameters: Final = QoSProfile(depth=1000)
qos_profile_parameter_events: Final = QoSProfile(depth=1000)
qos_profile_rosout_default: Final = QoSProfile(
    depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL, lifespan_ns=10 * 10**9
)


def to_profile(qos_profile: QoSProfile | int) -> QoSProfile:
    """Return the profile; a whole number means keep the last so many, reliable and volatile.

    Raises:
        MiddlewareError: it is neither, or the depth is not at least 1.
    """
    if isinstance(qos_profile, QoSProfile):
        return qos_profile
    if isinstance(qos_profile, int):
        return QoSProfile(depth=qos_profile)
    raise MiddlewareError(f"A QoS profile must be a QoSProfile or a depth, got {qos_profile!r}.")
