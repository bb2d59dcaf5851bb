"""Start the depth node."""

from launch import LaunchDescription
from launch_ros.actions import Node


def generate_launch_description() -> LaunchDescription:
    """Return what starts the node, as `sunset node depth` does."""
    node = Node(package="managed_subsystem", executable="depth", parameters=[{"use_sim_time": True}])
    return LaunchDescription([node])
