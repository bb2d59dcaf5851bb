"""Start all nodes of the managed system."""

from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import PathJoinSubstitution, ThisLaunchFileDir

NODES = ("camera", "depth", "image_enhancement", "sensor_fusion", "segmentation")


def generate_launch_description() -> LaunchDescription:
    """Return what starts every node from its own launch file; its arguments are those of node.launch.py."""
    return LaunchDescription(
        [
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(
                    PathJoinSubstitution([ThisLaunchFileDir(), f"{node}.launch.py"])
                )
            )
            for node in NODES
        ]
    )
