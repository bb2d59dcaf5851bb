"""Start one node of the managed system."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import LifecycleNode
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Return what starts the node, as `sunset node NODE` does."""
    name = LaunchConfiguration("node")
    file = PathJoinSubstitution([FindPackageShare("managed_subsystem"), "config", "parameters.yaml"])
    switches = {
        switch: ParameterValue(LaunchConfiguration(switch), value_type=bool)
        for switch in ("use_sim_time", "autostart")
    }
    return LaunchDescription(
        [
            DeclareLaunchArgument("node", description="name of the node"),
            DeclareLaunchArgument("use_sim_time", default_value="true", description="time comes from /clock"),
            DeclareLaunchArgument(
                "autostart", default_value="true", description="it configures and activates itself"
            ),
            DeclareLaunchArgument("params_file", default_value=file, description="parameters of the nodes"),
            LifecycleNode(
                package="managed_subsystem",
                executable=name,
                name=name,
                namespace="/managed_subsystem",
                parameters=[LaunchConfiguration("params_file"), switches],
            ),
        ]
    )
