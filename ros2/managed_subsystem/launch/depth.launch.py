"""Start the depth node."""

from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import PathJoinSubstitution, ThisLaunchFileDir


def generate_launch_description() -> LaunchDescription:
    """Return what starts the node; its arguments are those of node.launch.py."""
    file = PathJoinSubstitution([ThisLaunchFileDir(), "node.launch.py"])
    node = {"node": "depth"}
    return LaunchDescription(
        [IncludeLaunchDescription(PythonLaunchDescriptionSource(file), launch_arguments=node.items())]
    )
