"""The bag player, which publishes the recorded flight; live, it also gives the time and describes the camera."""

import sys
from collections.abc import Callable
from math import radians, tan
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Unpack

from sunset.errors import ParameterError
from sunset.harness.frames import LazyFrames
from sunset.image_messages import image_of_bgr, image_of_depth, image_of_labels
from sunset.system import BAG_PLAYER, CLOCK_TOPIC, NAMESPACE, SENSOR_TOPICS, TRUTH_TOPIC
from sunset_ros.clock import Clock
from sunset_ros.interfaces.builtin_interfaces.msg import Time
from sunset_ros.interfaces.geometry_msgs.msg import Quaternion, Transform, TransformStamped
from sunset_ros.interfaces.rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from sunset_ros.interfaces.rosgraph_msgs.msg import Clock as ClockMessage
from sunset_ros.interfaces.sensor_msgs.msg import CameraInfo, Image
from sunset_ros.interfaces.stamps import NS_PER_S, stamp_of
from sunset_ros.interfaces.std_msgs.msg import Header
from sunset_ros.interfaces.std_srvs.srv import Trigger
from sunset_ros.interfaces.tf2_msgs.msg import TFMessage
from sunset_ros.node import Node, NodeOptions
from sunset_ros.qos import DurabilityPolicy, QoSProfile
from sunset_ros.time import ClockType

if TYPE_CHECKING:
    from sunset.data import BagReader
    from sunset_ros.timer import Timer


_INFO_TOPICS: Final = ("/camera_info", f"{NAMESPACE}/camera_info")
"""Viewers expect them beside the topics of the images."""
_OPTICAL: Final = Quaternion(x=-0.5, y=0.5, z=-0.5, w=0.5)
"""From axes that point forward, left and up to those of an image: right, down and forward (REP 103)."""
_TICK_S: Final = 0.01
"""Time between two messages on `/clock` of a live system, as they show it."""


class BagPlayer(Node):
    """Publishes `/rgb_raw`, `/depth_raw`, `/gt_segmentation` and `/clock` from a bag.

    The stamps are the bag's. The service `~/start` (std_srvs/srv/Trigger) starts it from the first frame, even while it
    plays.

    Parameters:
        bag: a rosbag2 folder or file.
        start_frame: the first frame.
        frames: the number of frames; 0 for all frames that follow, without an end if `loop`.
        loop: whether the bag's first frame follows its last, after the bag's mean time between two frames.
        rate: frames per second.
        phase: seconds from the start to the first frame.

    Args:
        frames: the frames of an open bag; None to open the bag that the parameter names.
        options: as in `Node`.
    """

    _frame_id = "camera"
    _speed = 1.0

    def __init__(self, *, frames: LazyFrames | None = None, **options: Unpack[NodeOptions]) -> None:
        super().__init__(BAG_PLAYER, **options)
        self._declare_parameters()
        self._frames = frames or LazyFrames(self._named_bag(), None)
        self._range = self._chosen_frames()
        self._next = self._range.start
        self._timer: Timer | None = None
        self._rgb, self._depth = (self.create_publisher(Image, topic, 10) for topic in SENSOR_TOPICS)
        self._truth = self.create_publisher(Image, TRUTH_TOPIC, 10)
        self._time = self.create_publisher(ClockMessage, CLOCK_TOPIC, 10)
        self.create_service(Trigger, "~/start", self._on_start)

    def _declare_parameters(self) -> None:
        self._declare("bag", "", "a rosbag2 folder or file")
        self._declare("start_frame", 0, "first frame that is played", whole=2**31 - 1)
        self._declare("frames", 0, "how many frames are played; 0 for all that follow", whole=2**31 - 1)
        self._declare("loop", False, "whether the bag's first frame follows its last")
        self._declare("rate", 10.0, "frames per second", least=0.1, most=1000.0)
        self._declare("phase", 0.0, "seconds to the first frame", most=60.0)

    def _declare(
        self,
        name: str,
        default: float | str,
        text: str,
        *,
        whole: int = 0,
        least: float = 0.0,
        most: float = 0.0,
    ) -> None:
        descriptor = ParameterDescriptor(name=name, description=text, read_only=True)
        if whole:
            descriptor.integer_range = [IntegerRange(from_value=0, to_value=whole)]
        if most:
            descriptor.floating_point_range = [FloatingPointRange(from_value=least, to_value=most)]
        self.declare_parameter(name, default, descriptor)

    def _value(self, name: str) -> Any:
        return self.get_parameter(name).value

    def _named_bag(self) -> "BagReader":
        name = self._value("bag")
        if not name:
            raise ParameterError(
                "The bag player needs the parameter bag: the path of a rosbag2 folder or file."
            )
        from sunset.data import read_bag  # noqa: PLC0415  slow, and only the bag player's process needs it

        return read_bag(Path(name), size=self._size())

    def _size(self) -> tuple[int, int] | None:
        """Return the height and width of the frames; None for the bag's."""
        return None

    def _chosen_frames(self) -> range:
        start, count, length = self._value("start_frame"), self._value("frames"), len(self._frames.bag)
        loop = self._value("loop")
        stop = start + count if count else sys.maxsize if loop else length
        if start >= length or (stop > length and not loop):
            raise ParameterError(
                f"The bag {self._value('bag')} has {length} frames, which is too few for "
                f"{count or 'any'} from frame {start} on."
            )
        return range(start, stop)

    def _on_start(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        del request
        self._next = self._range.start
        self._schedule(self._value("phase") / self._speed, self._play_first)
        response.success = True
        endless = self._range.stop == sys.maxsize
        response.message = "Playing the bag in a loop." if endless else f"Playing {len(self._range)} frames."
        return response

    def _schedule(self, period: float, callback: Callable[[], None]) -> None:
        self._stop()
        self._timer = self.create_timer(period, callback)

    def _stop(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self.destroy_timer(self._timer)
            self._timer = None

    def _play_first(self) -> None:
        self._schedule(1.0 / self._value("rate") / self._speed, self._play)
        self._play()

    def _play(self) -> None:
        if self._next not in self._range:
            self._stop()
            return
        frame = self._frames.frame(self._next % len(self._frames.bag))
        stamp = self._stamp()
        header = Header(stamp=stamp, frame_id=self._frame_id)
        self._truth.publish(image_of_labels(header, frame.labels))
        self._rgb.publish(image_of_bgr(header, frame.rgb))
        self._depth.publish(image_of_depth(header, frame.depth))
        self._describe(header)
        self._next += 1

    def _describe(self, header: Header) -> None:
        """Publish the other messages of a frame."""

    def _stamp(self) -> Time:
        """Publish the time of the next frame on `/clock`, and return it."""
        stamps = self._frames.bag.stamps_ns
        laps, number = divmod(self._next, len(stamps))
        span_ns = int(stamps[-1] - stamps[0])
        period_ns = span_ns // (len(stamps) - 1) if span_ns else round(NS_PER_S / self._value("rate"))
        stamp = stamp_of(int(stamps[number]) + laps * (span_ns + period_ns))
        self._time.publish(ClockMessage(clock=stamp))
        return stamp


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

    _frame_id = "camera_optical_frame"

    def __init__(self, **options: Unpack[NodeOptions]) -> None:
        super().__init__(**options)
        self._speed = float(self._value("speed"))
        self._steady = Clock(clock_type=ClockType.STEADY_TIME, context=self.context)
        began_ns = self.get_clock().now().nanoseconds
        # the steady clock never jumps
        self._offset_ns = began_ns - (self._value("origin_ns") or began_ns) - self._steady.now_ns()
        # not by /clock, which this node publishes: it would never begin
        self.create_timer(_TICK_S / self._speed, self._tick, clock=self._steady)
        self._infos = [self.create_publisher(CameraInfo, topic, 10) for topic in _INFO_TOPICS]
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._transforms = self.create_publisher(TFMessage, "/tf_static", latched)
        header = Header(stamp=self._stamp(), frame_id="camera_link")
        optical = TransformStamped(
            header=header, child_frame_id=self._frame_id, transform=Transform(rotation=_OPTICAL)
        )
        self._transforms.publish(TFMessage(transforms=[optical]))

    def _declare_parameters(self) -> None:
        super()._declare_parameters()
        self._declare("width", 0, "width of the frames in pixels; 0 for the bag's", whole=2**14)
        self._declare("height", 0, "height of the frames in pixels; 0 for the bag's", whole=2**14)
        self._declare("speed", 1.0, "seconds of /clock in a second", least=0.01, most=100.0)
        self._declare(
            "field_of_view", 90.0, "camera's horizontal angle of view in degrees", least=1.0, most=179.0
        )
        self._declare("origin_ns", 0, "system time at which /clock is 0; 0 for the start of this node")

    def _size(self) -> tuple[int, int] | None:
        size = (self._value("height"), self._value("width"))
        return size if all(size) else None

    def _stamp(self) -> Time:
        # 0 means on /clock that there is no time yet
        return stamp_of(max(1, round((self._steady.now_ns() + self._offset_ns) * self._speed)))

    def _tick(self) -> None:
        self._time.publish(ClockMessage(clock=self._stamp()))

    def _describe(self, header: Header) -> None:
        height, width = self._frames.bag.size
        focal = width / 2 / tan(radians(self._value("field_of_view")) / 2)
        x, y = (width - 1) / 2, (height - 1) / 2  # the centre of the first pixel is 0
        info = CameraInfo(
            header=header,
            height=height,
            width=width,
            distortion_model="plumb_bob",
            d=[0.0] * 5,
            k=[focal, 0, x, 0, focal, y, 0, 0, 1],
            r=[1, 0, 0, 0, 1, 0, 0, 0, 1],
            p=[focal, 0, x, 0, 0, focal, y, 0, 0, 0, 1, 0],
        )
        for publisher in self._infos:
            publisher.publish(info)
