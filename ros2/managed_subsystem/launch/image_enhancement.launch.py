"""Start the image enhancement node."""

from launch import LaunchDescription
from launch_ros.actions import Node


def generate_launch_description() -> LaunchDescription:
    """Return what starts the node, as `sunset node image_enhancement` does."""
    node = Node(
        package="managed_subsystem", executable="image_enhancement", parameters=[{"use_sim_time": True}]
    )
    return LaunchDescription([node])
