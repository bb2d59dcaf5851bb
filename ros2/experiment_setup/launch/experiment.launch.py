"""Start the managed system, the flight that it sees, and the nodes that inject, watch and evaluate."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node, SetParameter
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Return what starts them; the flight begins and faults are injected when the services say so."""
    system = PathJoinSubstitution([FindPackageShare("managed_subsystem"), "launch", "full_system.launch.py"])
    sim_time = {"use_sim_time": True}
    bag = {
        "bag": ParameterValue(LaunchConfiguration("bag"), value_type=str),
        "speed": ParameterValue(LaunchConfiguration("rate"), value_type=float),
        "width": ParameterValue(LaunchConfiguration("width"), value_type=int),
        "height": ParameterValue(LaunchConfiguration("height"), value_type=int),
    }
    sharpness = ParameterValue(LaunchConfiguration("sharpness_threshold"), value_type=float)
    scenario = {"scenario": ParameterValue(LaunchConfiguration("scenario"), value_type=str)}
    return LaunchDescription(
        [
            DeclareLaunchArgument("bag", description="a rosbag2 with the flight"),
            DeclareLaunchArgument("scenario", description="a scenario's name or file, or faults joined by +"),
            DeclareLaunchArgument("sharpness_threshold", description="'sunset models show lite' prints it"),
            DeclareLaunchArgument("width", default_value="256", description="of the model, in pixels"),
            DeclareLaunchArgument("height", default_value="144", description="of the model, in pixels"),
            DeclareLaunchArgument("rate", default_value="1.0", description="seconds of /clock in a second"),
            Node(package="experiment_setup", executable="monitor", parameters=[sim_time]),
            Node(package="experiment_setup", executable="evaluator", parameters=[sim_time]),
            Node(package="experiment_setup", executable="scenario_executor", parameters=[sim_time, scenario]),
            Node(package="experiment_setup", executable="bag_player", parameters=[bag]),
            # of all nodes that are started after it, of which the camera has it
            SetParameter("sharpness_threshold", sharpness),
            IncludeLaunchDescription(PythonLaunchDescriptionSource(system)),
        ]
    )
