"""The embedded engine alone: what it leaves out, two threads at one executor, interface files."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import rclpy.node
from rcl_interfaces.msg import Log
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String

from archo_tui.base.errors import ArchoError
from archo_tui.ros.embedded.idl import FieldType, InterfaceError, parse
from archo_tui.user_code import interfaces as own_interfaces
from tests.support import chosen
from tests.support.ros import Ros
from tests.support.waiting import wait_until

EMBEDDED = pytest.mark.skipif(chosen.ENGINE != "embedded", reason="the embedded engine's own")


@EMBEDDED
def test_a_program_may_ask_first_whether_a_name_is_there() -> None:
    assert not hasattr(rclpy.node, "Waitable")
    assert not hasattr(Node, "create_guard_condition")
    with pytest.raises(AttributeError, match=r"no rclpy\.node\.Waitable: if real ROS 2 has it"):
        _ = rclpy.node.Waitable  # type: ignore[attr-defined]


@EMBEDDED
def test_a_message_that_a_module_only_imports_need_not_have_been_used_before() -> None:
    code = (
        "from archo_tui.ros import engine\nengine.activate('embedded')\n"
        "from rclpy.node import FloatingPointRange, IntegerRange\nprint(IntegerRange())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "IntegerRange(" in done.stdout, done.stderr


@EMBEDDED
def test_a_lone_surrogate_in_a_log_line_does_not_end_the_node(ros: Ros) -> None:
    lines: list[Any] = []
    ros.spun("listener").create_subscription(Log, "/rosout", lines.append, 50, raw=True)
    node = ros.node("talker")
    assert node.get_logger().info("odd \udc80 name")
    wait_until(lambda: any("odd \ufffd name".encode() in line for line in [*lines]))


@EMBEDDED
@pytest.mark.parametrize("name", ["content_filter_options", "qos_overriding_options"])
def test_an_argument_that_the_engine_lacks_is_refused_and_not_ignored(ros: Ros, name: str) -> None:
    given: Any = {name: object()}
    with pytest.raises(TypeError, match=name):
        ros.node().create_subscription(String, "topic", print, 10, **given)


# Not among the contracts: rclpy shares one generator between two threads, and may raise.


@contextmanager
def thread(work: Callable[[], object]) -> Iterator[None]:
    """Somebody else who spins, until the end."""
    runs = threading.Thread(target=work, name="spin", daemon=True)
    runs.start()
    yield
    runs.join(30)
    assert not runs.is_alive(), "the other thread waits for ever"


@EMBEDDED
def test_a_task_wakes_the_one_who_still_waits(ros: Ros) -> None:
    executor, done = SingleThreadedExecutor(context=ros.context), list[bool]()
    with thread(lambda: executor.spin_once(60.0)):
        executor.spin_once(0.1)  # in vain
        executor.create_task(done.append, True)
        wait_until(lambda: done, "the task", deadline=10)
    executor.shutdown()


@EMBEDDED
def test_a_shutdown_ends_the_spin_that_still_waits(ros: Ros) -> None:
    executor, ended = SingleThreadedExecutor(context=ros.context), list[bool]()

    def spin() -> None:
        with pytest.raises(ExternalShutdownException):
            executor.spin_once(60.0)
        ended.append(True)

    with thread(spin):
        executor.spin_once(0.1)
        ros.context.try_shutdown()
        wait_until(lambda: ended, "the other spin to end", deadline=10)
    executor.shutdown()


# What rosidl_adapter 4.9.5 (Kilted) makes of lines of .msg files, asked line by line: a constant is
# given by its value, a field by its type and its default.
LINES = json.loads(
    (Path(__file__).parent.parent / "share" / "interface_lines_kilted.json").read_text()
)


def message(folder: Path, text: str) -> Path:
    file = folder / "M.msg"
    file.write_bytes(text.encode())
    return file


def written(kind: FieldType) -> str:
    """The type as an interface file has it."""
    text = kind.base if kind.string_bound is None else f"{kind.base}<={kind.string_bound}"
    if not kind.is_array:
        return text
    size = f"<={kind.upper_bound}" if kind.upper_bound else kind.fixed_size or ""
    return f"{text}[{size}]"


def test_lines_are_read_as_rosidl_adapter_reads_them(tmp_path: Path) -> None:
    for text, wanted in LINES["read"]:
        (read,) = parse(message(tmp_path, text), "pkg")
        found: dict[str, object] = {name: value for name, _, value in read.constants}
        found |= {field.name: (written(field.type), field.default) for field in read.fields}
        assert repr(found) == wanted, text  # 1, 1.0 and True are three values; nan is nan


def test_lines_that_rosidl_adapter_refuses_name_file_and_line(tmp_path: Path) -> None:
    for text in LINES["refused"]:
        file = message(tmp_path, f"# first\n{text}")
        with pytest.raises(InterfaceError) as caught:
            parse(file, "pkg")
        said = str(caught.value)
        assert said.startswith((f"{file}:2: ", f"{file}:3: ")), (text, said)  # of two lines
        assert len(said.splitlines()) == 1, said


# packages by the files in them, and what is said of them
Files = dict[str, str | bytes | None]  # by path, with their texts; None: without it
WRONG: dict[str, tuple[Files, str]] = {
    "itself": ({"msg/A.msg": "int32 x\nA a\n"}, "msg/A.msg:2: A contains A: no message can"),
    "a circle": (
        {"msg/A.msg": "B b\n", "msg/B.msg": "int32 x\nA a\n"},
        "msg/B.msg:2: A contains B contains A: no message can",
    ),
    "not UTF-8": ({"msg/A.msg": b"int32 x\nint32 \xff\n"}, "msg/A.msg:2: not UTF-8"),
    "a name": ({"msg/bad-name.msg": "int32 x\n"}, "msg/bad-name.msg:1: bad-name is not a name"),
    "a word of Python": ({"msg/A.msg": "int8 x\nint8 class\n"}, "A.msg:2: 'class' is a word of"),
    "a line less": ({"srv/Reset.srv": "bool x\n"}, "Reset.srv:1: a .srv file has 1 '---' lines"),
    "a default": ({"msg/A.msg": "float32 x 1e39\n"}, "msg/A.msg:1: 1e+39 is too large"),
    "no package.xml": ({"package.xml": None}, "package.xml: No such file or directory"),
    "no XML": ({"package.xml": "<package>\n<name>\n"}, "package.xml:3: not XML"),
    "no name": ({"package.xml": "<package/>\n"}, "package.xml:1: no <name>: it names the package"),
    "a package's name": (
        {"package.xml": "<package>\n<name>My-Own</name></package>\n"},
        "package.xml:1: 'My-Own' is not a name of a package",
    ),
    "an own builtin_interfaces": (
        {"package.xml": "<package>\n<name>builtin_interfaces</name></package>\n"},
        "package.xml:1: the engine needs builtin_interfaces as it is: take another name",
    ),
}


def package(folder: Path, files: Files) -> Path:
    given: Files = {"package.xml": "<package><name>own</name></package>", "msg/Z.msg": "int8 z\n"}
    for name, text in (given | files).items():
        if text is not None:
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_bytes(text.encode() if isinstance(text, str) else text)
    return folder


@pytest.mark.parametrize("what", WRONG)
def test_a_package_that_cannot_be_used_is_one_line(tmp_path: Path, what: str) -> None:
    files, said = WRONG[what]
    with pytest.raises(ArchoError) as caught:
        own_interfaces.find([package(tmp_path, files)], "embedded")
    line = str(caught.value)
    assert said in line
    assert line.startswith(f"{tmp_path}{os.sep}")
    assert len(line.splitlines()) == 1


CODE = """
from archo_tui.ros import engine
from pathlib import Path
import sys
engine.activate("embedded", own={"own": Path(sys.argv[1])})
from own.msg import A
"""


def run(folder: Path, code: str) -> str:
    """What the code prints, in a process that has the package."""
    words = [sys.executable, "-c", CODE + code, str(folder)]
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout


def test_bytes_and_lists_of_a_file_are_those_of_rosidls_classes(tmp_path: Path) -> None:
    text = (
        "byte F=3\nfloat32 G=1e3\nbyte b 4\nbyte[] c [5]\nstring[] s [x]\nfloat64[] f [1e3, inf]\n"
    )
    package(tmp_path, {"msg/A.msg": text})
    told = "print(A.F, A.G, A().b, A().c)\nA().s.append('y')\nprint(A().s, list(A().f))"
    assert run(tmp_path, told) == "b'\\x03' 1000.0 b'\\x04' [b'\\x05']\n['x'] [1000.0, inf]\n"


def test_threads_that_ask_for_a_class_at_once_get_the_same_one(tmp_path: Path) -> None:
    files: Files = {f"msg/A{n}.msg": f"A{n + 1} a\n" for n in range(30)}
    package(tmp_path, {**files, "msg/A30.msg": "int8 x\n", "msg/A.msg": "A0 a\n"})
    told = (
        "from concurrent.futures import ThreadPoolExecutor\nimport own.msg\n"
        "with ThreadPoolExecutor(8) as pool:\n"
        "    names = [f'A{n % 31}' for n in range(248)]\n"
        "    made = list(pool.map(lambda name: getattr(own.msg, name), names))\n"
        "print(len(set(made)))"
    )
    assert run(tmp_path, told) == "31\n"


READING = """
from archo_tui.ros import engine
engine.activate("embedded")
from guest_interfaces.msg import Reading
print(Reading(value=3).value, Reading.get_fields_and_field_types())
print(Reading(), Reading() == Reading())
"""


def installed(folder: Path, text: str) -> Path:
    """A prefix with the package."""
    messages = folder / "share" / "guest_interfaces" / "msg"
    messages.mkdir(parents=True)
    (messages / "Reading.msg").write_text(text)
    return folder


def ask(*prefixes: Path) -> subprocess.CompletedProcess[str]:
    environ = os.environ | {"AMENT_PREFIX_PATH": os.pathsep.join(map(str, prefixes))}
    return subprocess.run(
        [sys.executable, "-c", READING], env=environ, capture_output=True, text=True, check=False
    )


def test_the_first_prefix_that_has_it_wins(tmp_path: Path) -> None:
    over = installed(tmp_path / "overlay", "int64 value\n")
    under = installed(tmp_path / "underlay", "int32 value\n")
    assert "int64" in ask(over, under).stdout


def test_a_package_that_is_nowhere_cannot_be_imported(tmp_path: Path) -> None:
    done = ask(tmp_path)
    assert done.returncode != 0
    assert "No module named 'guest_interfaces'" in done.stderr


def test_a_package_that_is_partial_in_one_place_is_completed_by_another(tmp_path: Path) -> None:
    partial = tmp_path / "partial" / "share" / "guest_interfaces" / "msg"
    partial.mkdir(parents=True)
    (partial / "Other.msg").write_text("int32 other\n")
    whole = installed(tmp_path / "whole", "int64 value\n")
    assert "int64" in ask(partial.parent.parent.parent, whole).stdout
