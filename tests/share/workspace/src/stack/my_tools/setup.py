from setuptools import setup

NODES = ("recorder", "player")

setup(
    name="my_tools",
    packages=["my_tools"],
    entry_points={"console_scripts": [f"{node} = my_tools.{node}:main" for node in NODES]},
)
