"""Messages and services of ROS: typed Python classes, CDR, type hashes.

The modules are generated from the .msg and .srv files beside them. `from sensor_msgs.msg import Image` of a
ROS 2 installation is `from sunset_ros.interfaces.sensor_msgs.msg import Image` here. The classes have the same
fields, constants and defaults; sequences and arrays of numbers are numpy arrays of the exact type.

>>> from sunset_ros.interfaces.std_msgs.msg import Header
>>> header = deserialize(serialize(Header(frame_id="camera")), Header)
>>> header
Header(stamp=Time(sec=0, nanosec=0), frame_id='camera')
"""

from sunset_ros.generator.definitions import FieldType as FieldType
from sunset_ros.interfaces._message import Message as Message
from sunset_ros.interfaces._message import Service as Service
from sunset_ros.interfaces._registry import field_types as field_types
from sunset_ros.interfaces._registry import get_message as get_message
from sunset_ros.interfaces._registry import get_service as get_service
from sunset_ros.interfaces._registry import message_definition as message_definition
from sunset_ros.interfaces._registry import type_hash as type_hash
from sunset_ros.interfaces._registry import type_name as type_name
from sunset_ros.interfaces._serialization import deserialize as deserialize
from sunset_ros.interfaces._serialization import serialize as serialize
