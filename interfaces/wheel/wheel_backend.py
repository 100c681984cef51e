"""A PEP 517 backend: scikit-build-core, told which ROS 2 to build for and where pip has put it.

`-C distro=kilted` builds for that distribution. The requirements of the build and of the wheel
depend on it; `distributions.py` lists them.
"""

from __future__ import annotations

import os
import shlex
from pathlib import Path
from typing import Any

import distributions
from scikit_build_core import build as _scikit_build
from scikit_build_core.build import build_sdist, get_requires_for_build_sdist

__all__ = [
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
    "prepare_metadata_for_build_wheel",
]

Settings = dict[str, Any] | None

# Of the current call, since scikit-build-core passes no settings to dynamic_metadata().
_distribution = distributions.DEFAULT


def get_requires_for_build_wheel(config_settings: Settings = None) -> list[str]:
    """Return what pip installs for the build, in an environment that is thrown away afterwards."""
    rest = _choose(config_settings)
    needed = [*distributions.BUILD[_distribution], *_messages()]
    return _scikit_build.get_requires_for_build_wheel(rest) + needed


def prepare_metadata_for_build_wheel(
    metadata_directory: str, config_settings: Settings = None
) -> str:
    """Write the metadata of the wheel, and return the name of its folder."""
    rest = _choose(config_settings)
    return _scikit_build.prepare_metadata_for_build_wheel(metadata_directory, rest)


def build_wheel(
    wheel_directory: str, config_settings: Settings = None, metadata_directory: str | None = None
) -> str:
    """Compile the interfaces with the environment's generators, and return the wheel's name."""
    import rosidl_cmake

    rest = _choose(config_settings)
    # The prefix above lib/python3.x/site-packages/rosidl_cmake/__init__.py.
    prefix = Path(rosidl_cmake.__file__).parents[4]
    fixups = Path(__file__).with_name("fixups.cmake")
    os.environ["AMENT_PREFIX_PATH"] = os.environ["CMAKE_PREFIX_PATH"] = str(prefix)
    os.environ["LD_LIBRARY_PATH"] = str(prefix / "lib")
    given = os.environ.get("CMAKE_ARGS", "")
    include = shlex.quote(f"-DCMAKE_PROJECT_INCLUDE={fixups}")  # The folder may have blanks.
    os.environ["CMAKE_ARGS"] = f"{given} {include}".strip()
    return _scikit_build.build_wheel(wheel_directory, rest, metadata_directory)


def dynamic_metadata(_settings: object, _project: object) -> dict[str, list[str]]:
    """Return the wheel's dependencies, for which scikit-build-core asks."""
    return {"dependencies": [*distributions.RUN[_distribution], *_messages()]}


def _messages() -> list[str]:
    """Return the wheels of the messages on which the package depends."""
    package = Path("package.xml").read_text(encoding="utf-8")
    known = distributions.MESSAGES[_distribution]
    return [wheel for name, wheel in known.items() if f"<depend>{name}</depend>" in package]


def _choose(config_settings: Settings) -> Settings:
    """Take the distribution out of the settings, and return the rest for scikit-build-core."""
    global _distribution
    rest = dict(config_settings or {})
    _distribution = rest.pop("distro", distributions.DEFAULT)
    if _distribution not in distributions.BUILD:
        known = " or ".join(f"-C distro={name}" for name in distributions.BUILD)
        raise SystemExit(f"cannot build for ROS 2 {_distribution!r}: {known}")
    return rest
