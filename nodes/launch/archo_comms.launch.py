"""Starts ARCHO's nodes; `use_sim:=true` also drains the battery faster than nature does."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

PACKAGE = "archo_bringup"


def generate_launch_description() -> LaunchDescription:
    """Three nodes, and the drain when asked."""
    config = Path(get_package_share_directory(PACKAGE)) / "config"
    parameters = [str(path) for path in sorted(config.glob("*.yaml"))]

    def node(name: str, **options: object) -> Node:
        return Node(
            package=PACKAGE,
            executable=name,
            name=name,
            output="screen",
            parameters=parameters,
            **options,
        )

    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "use_sim", default_value="false", description="also start fake_battery_drain"
            ),
            node("battery_monitor"),
            node("dashboard"),
            node("motor_controller"),
            node("fake_battery_drain", condition=IfCondition(LaunchConfiguration("use_sim"))),
        ]
    )
