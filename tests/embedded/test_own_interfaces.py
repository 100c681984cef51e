"""`--interfaces DIR`: a reader's own messages, without colcon."""

from __future__ import annotations

from pathlib import Path

import pytest

import archo_tui
from archo_tui.base.errors import ArchoError
from archo_tui.user_code import interfaces as own_interfaces
from tests.support import chosen
from tests.support.script import Script
from tests.support.shells import said
from tests.support.terminal import Terminal

INTERFACES = Path(archo_tui.__file__).parent.parent / "interfaces"
TELLER = """
from archo_interfaces.msg import BatteryStatus
from rclpy.node import Node

class Teller(Node):
    def __init__(self):
        super().__init__("teller")
        names = list(BatteryStatus.get_fields_and_field_types())
        self.create_timer(0.2, lambda: self.get_logger().warning(f"the last is {names[-1]}"))
"""


def package(folder: Path, *lines: str) -> Path:
    """A workspace's src/ with a battery of the reader's own."""
    ours = folder / "src" / "robot" / "my_archo"
    (ours / "msg").mkdir(parents=True, exist_ok=True)
    (ours / "package.xml").write_text("<package><name>archo_interfaces</name></package>")
    text = (INTERFACES / "msg" / "BatteryStatus.msg").read_text()
    (ours / "msg" / "BatteryStatus.msg").write_text("\n".join([text, *lines, ""]))
    return folder / "src"


def things(source: Path, **lines: str) -> None:
    """Write packages by their names, each with a Thing.msg of that line."""
    for name, line in lines.items():
        folder = source / name / "msg"
        folder.mkdir(parents=True)
        (folder / "Thing.msg").write_text(f"{line}\n")
        (folder.parent / "package.xml").write_text(f"<package><name>{name}</name></package>\n")


@pytest.mark.real_time
@pytest.mark.skipif(chosen.ENGINE != "embedded", reason="ROS 2 builds interfaces by colcon")
def test_a_saved_interface_restarts_everything_and_a_broken_one_does_not(tmp_path: Path) -> None:
    source = package(tmp_path, "float32 temperature")
    node = tmp_path / "teller.py"
    node.write_text(TELLER)
    terminal = Terminal("--interfaces", str(source), "--node", str(node))
    terminal.until("the last is temperature")
    package(tmp_path, "float32 humidity", "what is this")
    terminal.until("BatteryStatus.msg:")  # its file and line, and all goes on
    package(tmp_path, "float32 humidity")
    terminal.until("the last is humidity")
    terminal.write("g7\r")
    terminal.until("MOVING to 7")  # the robot's own nodes took it, too
    assert said("wait", "arrived", "--timeout", "0").code == 4  # other programs reach it again
    terminal.write("\x03")
    terminal.until("CANCELLED")
    terminal.write("q")
    assert terminal.exit_code() == 0
    assert terminal.is_as_before()
    terminal.close()


@pytest.mark.real_time
@pytest.mark.skipif(chosen.ENGINE != "embedded", reason="ROS 2 builds interfaces by colcon")
def test_of_the_keys_typed_while_it_restarts_only_stop_counts(tmp_path: Path) -> None:
    source = package(tmp_path, "float32 temperature")
    terminal = Terminal("--interfaces", str(source))
    terminal.until("max_speed")
    package(tmp_path, "float32 humidity")
    terminal.until("the console restarts; ^x is STOP meanwhile")
    terminal.write("g7\r\x18")
    terminal.until("STOP was read while the console restarted: sent now")
    terminal.until("✗ STOPPED")
    assert "No goal yet" in said("status").out
    package(tmp_path, "float32 pressure")
    terminal.until("the restart waits: release the STOP, then press ^r in Nodes")
    terminal.write("\x11")
    assert terminal.exit_code() == 0
    assert terminal.is_as_before()
    terminal.close()


@pytest.mark.real_time
@pytest.mark.skipif(chosen.ENGINE != "embedded", reason="ROS 2 builds interfaces by colcon")
def test_in_plain_a_saved_interface_counts_from_the_next_start_and_that_is_said(
    tmp_path: Path,
) -> None:
    source = package(tmp_path, "float32 temperature")
    script = Script("--interfaces", str(source))
    script.type("status\n")
    script.until("battery ")
    package(tmp_path, "float32 humidity")
    script.until("interfaces were saved: they count from the next start on")
    script.type("quit\n")
    script.end()


def test_without_a_package_or_on_ros_2_it_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(ArchoError, match="no interface package"):
        own_interfaces.find([tmp_path], "embedded")
    with pytest.raises(ArchoError, match=r"colcon build .* --packages-select archo_interfaces"):
        own_interfaces.find([package(tmp_path)], "ros2")


def test_a_second_folder_adds_to_the_first_and_may_use_its_types(tmp_path: Path) -> None:
    things(tmp_path, first_msgs="float32 x", second_msgs="first_msgs/Thing inner")
    folders = [tmp_path / "first_msgs", tmp_path / "second_msgs"]
    assert [*own_interfaces.find(folders, "embedded").packages] == ["first_msgs", "second_msgs"]


def test_of_several_packages_one_with_a_mistake_is_named_and_the_others_are_used(
    tmp_path: Path,
) -> None:
    things(tmp_path, bad_msgs="floot32 x", good_msgs="float32 x", user_msgs="bad_msgs/Thing inner")
    (tmp_path / "worse_msgs" / "msg").mkdir(parents=True)
    (tmp_path / "worse_msgs" / "package.xml").write_text("<package>\n")
    packages, warnings = own_interfaces.find([tmp_path], "embedded")
    assert "good_msgs" in packages
    worse, bad = warnings  # user_msgs is not at fault
    assert worse.startswith(f"{tmp_path / 'worse_msgs' / 'package.xml'}:2: not XML")
    assert bad.startswith(f"{tmp_path / 'bad_msgs' / 'msg' / 'Thing.msg'}:1: ")
    with pytest.raises(ArchoError, match=r"Thing\.msg:1: .*floot32"):  # alone it is given by name
        own_interfaces.find([tmp_path / "bad_msgs"], "embedded")


def test_a_known_mistake_does_not_keep_a_saved_package_from_counting(tmp_path: Path) -> None:
    things(tmp_path, bad_msgs="floot32 x", good_msgs="float32 x")
    said: list[str] = []
    packages = own_interfaces.find([tmp_path], "embedded").packages
    files = own_interfaces.OwnInterfaces(packages)

    def reload() -> None:
        files.reload(lambda *event: said.append(event[2]), said.append)

    reload()
    assert said == ["interfaces were saved"]
    (tmp_path / "good_msgs" / "msg" / "Thing.msg").write_text("float32 y\nfloot64 x\n")
    reload()
    (new,) = said[1:]
    assert new.startswith("not read: good_msgs/msg/Thing.msg:2: ")
