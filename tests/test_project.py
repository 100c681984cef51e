"""The project's own rules: what is imported when, generated files, packages."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests import mutants, screenshot, stubs

ROOT = Path(__file__).parent.parent


def test_the_command_line_starts_light() -> None:
    code = (
        "import sys, archo_tui.cli as cli; from archo_tui.cli.options import console_parser;"
        "console_parser().format_help();"
        "cli.main(['--version']); cli.main(['journal']);"
        "assert cli.main(['status', '--line']) == 3;"
        "heavy = {'textual', 'rclpy', 'rich', 'asyncio', 'yaml'} & set(sys.modules);"
        "sys.exit(f'imported: {heavy}' if heavy else 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_without_a_screen_textual_is_not_imported_and_nowhere_the_assistants_sdk() -> None:
    code = (
        "import sys, archo_tui.console.plain, archo_tui.cli, archo_tui.session.session;"
        "'textual' in sys.modules and sys.exit('Textual was imported');"
        "import archo_tui.screen.app, archo_tui.client.robot, archo_tui.client.shell;"
        "found = {'mcp', 'mcp_types', 'pydantic', 'anyio', 'archo_tui.client.mcp'};"
        "sys.exit(f'imported: {found & set(sys.modules)}' if found & set(sys.modules) else 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.night
def test_pydoc_knows_the_operators_verbs() -> None:
    words = [sys.executable, "-m", "pydoc", "archo_tui.robot.robot"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert "class Robot" in done.stdout
    assert "emergency_stop(robot" in done.stdout


def test_the_recorded_session_is_a_picture_that_a_page_loads_at_once() -> None:
    recorded = (ROOT / "session.svg").read_bytes()
    assert ElementTree.fromstring(recorded).get("viewBox")
    assert len(recorded) < screenshot.MOST


def test_each_room_has_tests_that_are_to_notice_its_faults() -> None:
    tests = {test for room in mutants.rooms(ROOT) for test in mutants.tests_of(room)}
    assert {test for test in tests if not (ROOT / test).exists()} == set()
    assert set(mutants.TESTS) <= set(mutants.rooms(ROOT))


def test_the_names_of_tests_are_sentences_that_are_read_at_once() -> None:
    texts = [path.read_text(encoding="utf-8") for path in Path("tests").rglob("test_*.py")]
    names = re.findall(r"def (test_\w+)", "".join(texts))
    assert [name for name in names if name.count("_") > 14] == []


# The rooms whose docstrings have yet to be written in the form of PEP 257 and Google's guide.
CLAUSES = (
    *("What", "How", "Whether", "That", "Where", "When", "Which", "Who", "Whose", "Why", "If"),
    *("As", "So", "Of", "Else", "Also", "And", "But", "Here", "There", "Nobody", "Nothing"),
    *("It", "Its", "Those", "These", "This", "They", "Them", "One", "He", "We", "You"),
)


def test_no_docstring_begins_with_a_clause_or_a_pronoun() -> None:
    begins = re.compile(rf':\n *"""(?:{"|".join(CLAUSES)})\b.*')
    found = [
        f"{path}: {docstring.strip()}"
        for path in sorted(Path("archo_tui").rglob("*.py"))
        for docstring in begins.findall(path.read_text(encoding="utf-8"))
    ]
    assert found == []


def test_the_stubs_are_what_the_interface_files_say() -> None:
    packages = stubs.shared_packages() | {"archo_interfaces": ROOT / "interfaces"}
    for relative, text in stubs.stubs(packages).items():
        path = ROOT / "typings" / relative
        assert path.is_file(), f"{path} is missing"
        assert path.read_text(encoding="utf-8") == text, (
            "run: python -m tests.stubs typings archo_interfaces=interfaces"
        )


@pytest.mark.parametrize("path", ["interfaces", "nodes"])
def test_ros_packages_say_who_they_are(path: str) -> None:
    package = ElementTree.parse(ROOT / path / "package.xml").getroot()
    assert package.findtext("license") == "Apache-2.0"
    assert package.findtext("version") == "0.2.0"


_PROGRAM = """
import sys
from archo_tui.ros import engine
engine.activate("embedded", hosting=True)
import archo_tui.screen.app
from archo_tui.base.imports import OF_THE_SCREEN, import_the_rest
replay = "archo_tui.screen.commands.replay", "archo_tui.recordings.replay.player"
print([name in sys.modules for name in replay])
import_the_rest(OF_THE_SCREEN)
print([name in sys.modules for name in replay])
"""

_WITH_INTERFACES = """
import sys
from pathlib import Path
import archo_tui.session.session
from archo_tui.user_code import interfaces
print("archo_tui.user_code.ros_launch.workspace" in sys.modules)
interfaces.find([Path("interfaces")], "embedded")
print("archo_tui.user_code.ros_launch.setup_script" in sys.modules)
"""


def test_what_runs_a_setup_is_not_imported_to_read_interfaces() -> None:
    done = subprocess.run(
        [sys.executable, "-c", _WITH_INTERFACES],
        capture_output=True,
        text=True,
        check=False,
        cwd=Path(__file__).parent.parent,
    )
    assert done.stderr == ""
    assert done.stdout.split() == ["False", "False"]


def test_a_replay_is_imported_behind_the_first_picture() -> None:
    done = subprocess.run(
        [sys.executable, "-c", _PROGRAM], capture_output=True, text=True, check=False
    )
    assert done.stderr == ""
    assert done.stdout.splitlines() == [str([False] * 2), str([True] * 2)]
