from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    return LaunchDescription(
        [
            DeclareLaunchArgument("rate", default_value="1.0", description="messages a second"),
            Node(
                package="my_robot",
                executable="talker",
                parameters=[{"rate": LaunchConfiguration("rate")}],
            ),
        ]
    )
