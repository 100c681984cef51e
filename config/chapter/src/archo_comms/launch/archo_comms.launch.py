import os

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    share = get_package_share_directory("archo_comms")
    parameters = os.path.join(share, "config", "motor_params.yaml")
    return LaunchDescription([
        DeclareLaunchArgument("use_sim", default_value="false"),
        Node(package="archo_comms", executable="battery_monitor", name="battery_monitor"),
        Node(package="archo_comms", executable="dashboard", name="dashboard"),
        Node(
            package="archo_comms",
            executable="motor_controller",
            name="motor_controller",
            parameters=[parameters],
        ),
        Node(
            package="archo_comms",
            executable="fake_battery_drain",
            name="fake_battery_drain",
            condition=IfCondition(LaunchConfiguration("use_sim")),
        ),
    ])
