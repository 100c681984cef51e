"""Where interface packages are looked for, in a process of its own for each question."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

CODE = """
from archo_tui.ros import engine
engine.activate("embedded")
from guest_interfaces.msg import Reading
print(Reading(value=3).value, Reading.get_fields_and_field_types())
"""


def package(folder: Path, text: str) -> Path:
    messages = folder / "share" / "guest_interfaces" / "msg"
    messages.mkdir(parents=True)
    (messages / "Reading.msg").write_text(text)
    return folder


def ask(*prefixes: Path) -> subprocess.CompletedProcess[str]:
    environ = os.environ | {"AMENT_PREFIX_PATH": os.pathsep.join(map(str, prefixes))}
    return subprocess.run(
        [sys.executable, "-c", CODE], env=environ, capture_output=True, text=True, check=False
    )


def test_a_package_is_found_on_the_prefix_path(tmp_path: Path) -> None:
    done = ask(tmp_path / "empty", package(tmp_path / "install", "int32 value\n"))
    assert done.stdout == "3 {'value': 'int32'}\n", done.stderr


def test_the_first_prefix_that_has_it_wins(tmp_path: Path) -> None:
    over = package(tmp_path / "overlay", "int64 value\n")
    under = package(tmp_path / "underlay", "int32 value\n")
    assert "int64" in ask(over, under).stdout


def test_a_package_that_is_nowhere_cannot_be_imported(tmp_path: Path) -> None:
    done = ask(tmp_path)
    assert done.returncode != 0
    assert "No module named 'guest_interfaces'" in done.stderr


def test_a_package_that_is_partial_in_one_place_is_completed_by_another(tmp_path: Path) -> None:
    partial = tmp_path / "partial" / "share" / "guest_interfaces" / "msg"
    partial.mkdir(parents=True)
    (partial / "Other.msg").write_text("int32 other\n")
    whole = package(tmp_path / "whole", "int64 value\n")
    assert "int64" in ask(partial.parent.parent.parent, whole).stdout


def test_a_byte_has_the_default_that_its_file_gives(tmp_path: Path) -> None:
    text = "byte flag 7\nint32 value\n"
    assert ask(package(tmp_path / "install", text)).stdout.startswith("3 {'flag': 'octet'")
    code = "from archo_tui.ros import engine\nengine.activate('embedded')\n"
    code += "from guest_interfaces.msg import Reading\nprint(Reading(), Reading() == Reading())"
    environ = os.environ | {"AMENT_PREFIX_PATH": str(tmp_path / "install")}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environ, capture_output=True, text=True, check=False
    )
    assert "flag=b'\\x07', value=0) True" in done.stdout, done.stderr
