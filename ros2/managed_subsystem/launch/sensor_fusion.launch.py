"""Start the sensor fusion node."""

from launch import LaunchDescription
from launch_ros.actions import Node


def generate_launch_description() -> LaunchDescription:
    """Return what starts the node, as `sunset node sensor_fusion` does."""
    node = Node(package="managed_subsystem", executable="sensor_fusion", parameters=[{"use_sim_time": True}])
    return LaunchDescription([node])
