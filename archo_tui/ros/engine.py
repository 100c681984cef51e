"""The choice of the engine that `import rclpy` means in this process."""

from __future__ import annotations

import importlib
import importlib.util
import os
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from archo_tui.base.errors import ArchoError
from archo_tui.ros import embedded
from archo_tui.ros.release import distribution

if TYPE_CHECKING:
    from rclpy.context import Context

EMBEDDED, ROS2 = "embedded", "ros2"
ENGINES = (EMBEDDED, ROS2)

_CHECKOUT = Path(__file__).parent.parent.parent
_GET_ROS = (
    "source an installation (. /opt/ros/jazzy/setup.bash) or, on Linux x86-64, "
    "in a clone of archo-tui: pip install '.[ros2]' ./interfaces (docs/ros2.md)"
)
_GET_INTERFACES = (
    "pip install ./interfaces, or colcon build --packages-select archo_interfaces and source "
    "install/setup.bash"
)
# The packages of the robot's own nodes; another robot may need fewer.
_NEEDED = {
    "msg": ("BatteryStatus", "MotorStatus"),
    "srv": ("EmergencyStop", "ResetEncoder"),
    "action": ("MoveToShelf",),
}


def activate(name: str, *, hosting: bool = True, own: Mapping[str, Path] | None = None) -> None:
    """Make `import rclpy` mean the named engine, before anything imports it.

    ROS 2 is imported by this call. `hosting` demands every interface of the robot's own nodes (ROS
    2 only); `own` are the user's packages (embedded only). ArchoError says what to type if
    something is missing, or the process uses the other engine.
    """
    if name not in ENGINES:
        raise ArchoError(f"no engine {name!r}: one of {', '.join(ENGINES)}")
    if name == ROS2:
        _activate_ros2(hosting)
        return
    try:
        embedded.install(interface_packages(), own)
    except RuntimeError as error:
        raise ArchoError(f"cannot use the embedded engine: {error}") from None


def ensure() -> None:
    """Activate the embedded engine unless rclpy is imported already: pydoc only imports modules."""
    if "rclpy" not in sys.modules:
        activate(EMBEDDED)


def _activate_ros2(hosting: bool) -> None:
    if embedded.is_installed():
        raise ArchoError("cannot use ROS 2: this process already uses the embedded engine")
    if importlib.util.find_spec("rclpy") is None:
        raise ArchoError(f"ROS 2 was not found (no module rclpy): {_GET_ROS}")
    _check_rmw()
    try:
        importlib.import_module("rclpy")
    except Exception as error:
        raise ArchoError(f"ROS 2 cannot be loaded ({_first_line(error)}): {_GET_ROS}") from None
    if not hosting:  # What is missing is reported where it is needed.
        return
    if importlib.util.find_spec("archo_interfaces") is None:
        raise ArchoError(f"archo_interfaces is not installed: {_GET_INTERFACES}")
    missing = _missing_interfaces()
    if missing:
        raise ArchoError(
            f"archo_interfaces is out of date, it lacks {', '.join(missing)}: {_GET_INTERFACES}"
        )


_LOADED = 10.0  # Seconds in which rclpy's library loads even from a slow disk.
_LOAD = "import ctypes, sys; ctypes.CDLL(sys.argv[1])"


def _check_rmw() -> None:
    """Raise ArchoError if the environment names a middleware that ROS 2 cannot load.

    rcl ends the whole process for it while rclpy is imported, so another process tries first, for
    10 s at most.
    """
    name = os.environ.get("RMW_IMPLEMENTATION", "")
    if not name or "rclpy" in sys.modules:
        return
    spec = importlib.util.find_spec("rclpy")
    folders = (spec and spec.submodule_search_locations) or ()
    libraries = [found for folder in folders for found in Path(folder).glob("_rclpy_pybind11*")]
    if not libraries:
        return
    import subprocess

    tried = [sys.executable, "-S", "-c", _LOAD, str(libraries[0])]
    try:
        done = subprocess.run(
            tried, capture_output=True, text=True, errors="replace", timeout=_LOADED, check=False
        )
    except (OSError, subprocess.SubprocessError):  # The import below tells what is wrong.
        return
    if done.returncode and "[rcl]" in done.stderr:
        found = re.search(r"instead found '(\w+)'", done.stderr)
        other = f" (here is {found[1]})" if found else ""
        package = f"ros-{distribution() or 'DISTRO'}-{name.replace('_', '-')}"
        raise ArchoError(
            f"RMW_IMPLEMENTATION names {name}, which is not installed{other}: "
            f"install {package}, or unset RMW_IMPLEMENTATION"
        )


def _missing_interfaces() -> list[str]:
    missing = []
    for kind, names in _NEEDED.items():
        try:
            module = importlib.import_module(f"archo_interfaces.{kind}")
        except ImportError:
            module = None
        missing += [f"{kind}/{name}" for name in names if not hasattr(module, name)]
    if "msg/BatteryStatus" not in missing:
        fields = importlib.import_module("archo_interfaces.msg").BatteryStatus
        if "battery_health" not in fields.get_fields_and_field_types():
            missing.append("msg/BatteryStatus.battery_health")
    return missing


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]


def interface_packages() -> dict[str, Path]:
    """Return the folders of the interface packages besides the engine's own, by name."""
    folder = _CHECKOUT / "interfaces"
    return {"archo_interfaces": folder} if (folder / "package.xml").is_file() else {}


def describe(name: str, context: Context) -> str:
    """Return the engine as the header shows it: `ROS 2 jazzy rmw_fastrtps_cpp domain 0`."""
    if name == EMBEDDED:
        return EMBEDDED
    from rclpy.utilities import get_rmw_implementation_identifier

    rmw = get_rmw_implementation_identifier()
    return " ".join(f"ROS 2 {distribution()} {rmw} domain {context.get_domain_id()}".split())


_LOCALHOST_ONLY = "ROS_LOCALHOST_ONLY"


def no_node_hint(name: str, context: Context) -> str:
    """Return where no node was found, and what to try: `on domain 0 (...): start ...`."""
    if name == EMBEDDED:
        return "in this process: give one by --node FILE, or leave out --only"
    from rclpy.utilities import get_rmw_implementation_identifier

    reach, rmw = _discovery_range(), get_rmw_implementation_identifier()
    tries = "start the robot, or match its ROS_DOMAIN_ID (`archo-tui look` tries 0 to 20) and RMW"
    if reach in ("LOCALHOST", "OFF"):
        tries = "for a robot elsewhere set ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET"
        if os.environ.get(_LOCALHOST_ONLY) == "1":  # It has precedence.
            tries = f"for a robot elsewhere unset {_LOCALHOST_ONLY}"
    return f"on domain {context.get_domain_id()} ({rmw}, discovery {reach}): {tries}"


def _discovery_range() -> str:
    """Return how far the environment lets ROS 2 look for nodes: `SUBNET`, `LOCALHOST`, `OFF`."""
    if os.environ.get(_LOCALHOST_ONLY) == "1":
        return "LOCALHOST"
    return os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "").upper() or "SUBNET"
