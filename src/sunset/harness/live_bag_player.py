"""The bag player of a live system, which also publishes the time and the camera's description."""

from math import radians, tan
from typing import Any, ClassVar, Final

from sunset.harness.bag_player import BagPlayer
from sunset.system import NAMESPACE
from sunset_ros.clock import Clock
from sunset_ros.interfaces.builtin_interfaces.msg import Time
from sunset_ros.interfaces.geometry_msgs.msg import Quaternion, Transform, TransformStamped
from sunset_ros.interfaces.rcl_interfaces.msg import FloatingPointRange, IntegerRange
from sunset_ros.interfaces.rosgraph_msgs.msg import Clock as ClockMessage
from sunset_ros.interfaces.sensor_msgs.msg import CameraInfo
from sunset_ros.interfaces.stamps import stamp_of
from sunset_ros.interfaces.std_msgs.msg import Header
from sunset_ros.interfaces.tf2_msgs.msg import TFMessage
from sunset_ros.qos import DurabilityPolicy, QoSProfile
from sunset_ros.time import ClockType

_TICK_S: Final = 0.01
"""Time between two messages on `/clock`, as they show it."""
_INFO_TOPICS: Final = ("/camera_info", f"{NAMESPACE}/camera_info")
"""Viewers expect them beside the topics of the images."""
_MOUNT: Final = "camera_link"
_OPTICAL: Final = Quaternion(x=-0.5, y=0.5, z=-0.5, w=0.5)
"""From axes that point forward, left and up to those of an image: right, down and forward (REP 103)."""


class LiveBagPlayer(BagPlayer):
    """Publishes `/clock` a hundred times a second from its start on, and stamps frames with that time.

    With each frame it publishes a `sensor_msgs/msg/CameraInfo` beside the images, and once, on `/tf_static`, the
    transform from the camera's frame to the images' frame.

    Parameters besides `BagPlayer`'s, whose times are of `/clock`:
        width, height: the size of the frames; 0 for the bag's.
        speed: seconds of `/clock` in a second.
        origin_ns: the system's time, nanoseconds since 1970, at which `/clock` is 0; 0 for the player's start.
        field_of_view: the camera's horizontal angle of view in degrees.
    """

    frame_id: ClassVar[str] = "camera_optical_frame"

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._speed = float(self._value("speed"))
        self._steady = Clock(clock_type=ClockType.STEADY_TIME, context=self.context)
        began_ns = self.get_clock().now().nanoseconds
        # the steady clock never jumps
        self._offset_ns = began_ns - (self._value("origin_ns") or began_ns) - self._steady.now_ns()
        self._infos = [self.create_publisher(CameraInfo, topic, 10) for topic in _INFO_TOPICS]
        kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._transforms = self.create_publisher(TFMessage, "/tf_static", kept)
        # not by /clock, which this node publishes: it would never begin
        self.create_timer(_TICK_S / self._speed, self._tick, clock=self._steady)
        mount = TransformStamped(
            header=Header(stamp=self._now(), frame_id=_MOUNT),
            child_frame_id=self.frame_id,
            transform=Transform(rotation=_OPTICAL),
        )
        self._transforms.publish(TFMessage(transforms=[mount]))

    def _declare_parameters(self) -> None:
        super()._declare_parameters()
        size = [IntegerRange(from_value=0, to_value=2**14)]
        speed = [FloatingPointRange(from_value=0.01, to_value=100.0)]
        self._declare("width", 0, "width of the frames in pixels; 0 for the bag's", integer_range=size)
        self._declare("height", 0, "height of the frames in pixels; 0 for the bag's", integer_range=size)
        self._declare("speed", 1.0, "seconds of /clock in a second", floating_point_range=speed)
        angle = [FloatingPointRange(from_value=1.0, to_value=179.0)]
        described = "horizontal angle of view of the camera in degrees"
        self._declare("field_of_view", 90.0, described, floating_point_range=angle)
        self._declare("origin_ns", 0, "system time at which /clock is 0; 0 for the start of this node")

    def _size(self) -> tuple[int, int] | None:
        size = (self._value("height"), self._value("width"))
        return size if all(size) else None

    def _now(self) -> Time:
        # 0 means on /clock that there is no time yet
        return stamp_of(max(1, round((self._steady.now_ns() + self._offset_ns) * self._speed)))

    def _tick(self) -> None:
        self._time.publish(ClockMessage(clock=self._now()))

    def _describe(self, header: Header) -> None:
        height, width = self._bag.size
        focal = width / 2 / tan(radians(self._value("field_of_view")) / 2)
        centre_x, centre_y = (width - 1) / 2, (height - 1) / 2  # the centre of the first pixel is 0
        info = CameraInfo(
            header=header,
            height=height,
            width=width,
            distortion_model="plumb_bob",
            d=[0.0] * 5,
            k=[focal, 0.0, centre_x, 0.0, focal, centre_y, 0.0, 0.0, 1.0],
            r=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            p=[focal, 0.0, centre_x, 0.0, 0.0, focal, centre_y, 0.0, 0.0, 0.0, 1.0, 0.0],
        )
        for publisher in self._infos:
            publisher.publish(info)

    def _stamp(self) -> Time:
        return self._now()
