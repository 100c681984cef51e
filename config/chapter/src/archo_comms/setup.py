from glob import glob

from setuptools import setup

setup(
    name="archo_comms",
    version="0.1.0",
    packages=["archo_comms"],
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/archo_comms"]),
        ("share/archo_comms", ["package.xml"]),
        ("share/archo_comms/launch", glob("launch/*.launch.py")),
        ("share/archo_comms/config", glob("config/*.yaml")),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    maintainer="you",
    maintainer_email="you@example.com",
    description="The nodes of the chapter.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "battery_monitor = archo_comms.battery_monitor:main",
            "dashboard = archo_comms.dashboard:main",
            "motor_controller = archo_comms.motor_controller:main",
            "fake_battery_drain = archo_comms.fake_battery_drain:main",
        ],
    },
)
