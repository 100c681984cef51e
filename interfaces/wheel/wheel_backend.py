"""PEP 517 backend: scikit-build-core, told where pip has put the ROS build packages."""

from __future__ import annotations

import os
import shlex
from pathlib import Path
from typing import Any

from scikit_build_core import build as _scikit_build
from scikit_build_core.build import *  # noqa: F403


def build_wheel(
    wheel_directory: str,
    config_settings: dict[str, Any] | None = None,
    metadata_directory: str | None = None,
) -> str:
    """Compile the interfaces with the generators of the build environment."""
    import rosidl_cmake

    # the prefix above lib/python3.x/site-packages/rosidl_cmake/__init__.py
    prefix = Path(rosidl_cmake.__file__).parents[4]
    fixups = Path(__file__).with_name("fixups.cmake")
    os.environ["AMENT_PREFIX_PATH"] = os.environ["CMAKE_PREFIX_PATH"] = str(prefix)
    os.environ["LD_LIBRARY_PATH"] = str(prefix / "lib")
    given = os.environ.get("CMAKE_ARGS", "")
    include = shlex.quote(f"-DCMAKE_PROJECT_INCLUDE={fixups}")  # the folder may have blanks
    os.environ["CMAKE_ARGS"] = f"{given} {include}".strip()
    name: str = _scikit_build.build_wheel(wheel_directory, config_settings, metadata_directory)
    return name
