"""Builds archo_bringup as a ROS 2 package (colcon, ament_python)."""

from glob import glob

from setuptools import setup

NAME = "archo_bringup"
NODES = ("battery_monitor", "dashboard", "motor_controller", "fake_battery_drain")

setup(
    name=NAME,
    version="0.2.0",
    packages=[NAME],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", glob("launch/*.launch.py")),
        (f"share/{NAME}/config", glob("../config/*.yaml")),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    maintainer="ARCHO maintainers",
    maintainer_email="maintainers@archo.example",
    description="The nodes of the ARCHO warehouse robot and the launch file that starts them.",
    license="Apache-2.0",
    entry_points={"console_scripts": [f"{node} = {NAME}.{node}:main" for node in NODES]},
)
