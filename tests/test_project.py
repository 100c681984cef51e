"""The project's own rules: what is imported when, generated files, packages."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests import mutants, recording, stubs

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


def test_the_recorded_session_shows_one_screen_after_the_other_for_ever() -> None:
    styles = ".terminal-{0}-matrix {{}} .terminal-{0}-title {{}} .terminal-{0}-r1 {{ fill: red }}"
    parts = '<text class="terminal-{0}-r1">both</text><text>{0}</text>'
    pictures = [
        f'<svg viewBox="0 0 9 9"><style>{styles.format(n)}</style>{parts.format(n)}</svg>'
        for n in "12"
    ]
    fonts = "<style>@font-face { a }\n"
    text = recording.joined([p.replace("<style>", fonts) for p in pictures], [1.0, 3.0])
    assert ElementTree.fromstring(text).get("viewBox") == "0 0 9 9"
    assert "s0 { 0% { visibility: hidden } 0.00% { visibility: visible } 25.00%" in text
    assert "s1 { 0% { visibility: hidden } 25.00% { visibility: visible } 99.99%" in text
    assert text.count("@font-face") == 1
    assert text.count(">both<") == text.count("fill: red") == 1
    assert text.count('<use href="#p0"/>') == 2
    recorded = (ROOT / "session.svg").read_bytes()
    assert ElementTree.fromstring(recorded).get("viewBox")
    assert len(recorded) < recording.MOST


def test_random_faults_are_planted_in_what_runs_only() -> None:
    text = b"""
@dataclass(frozen=True)
class Way:
    shelf: Literal[3]

    def __repr__(self) -> str:
        return "no"

    def left(self, now: float = 1.5) -> float | None:
        if TYPE_CHECKING:
            return 1
        if "\xc3\xa9" in self.notes or now < self.end is not None:
            self.tell(f"{now + 1}")
        while not self.over:
            self.get_logger().info("over", True)
        self.count += 2
        return self.end - now

    async def drive(self) -> None:
        await self.go(quickly=True)
        return None if self.over else print(self.name + "!")
"""
    found = mutants.mutants(text)
    planted = [ast.unparse(ast.parse(mutant.planted_in(text))) for mutant in found]
    assert len({*planted, ast.unparse(ast.parse(text))}) == len(found) + 1
    assert [mutant.after for mutant in found] == [
        "2.5",
        "not ('é' in self.notes or now < self.end is not None)",
        "('é' in self.notes and now < self.end is not None)",
        "('é' not in self.notes)",
        "(now <= self.end is not None)",
        "(now < self.end is None)",
        "pass",
        "not (not self.over)",
        "self.count -= 2",
        "3",
        "None",
        "(self.end + now)",
        "pass",
        "False",
        "not (self.over)",
    ]


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
    import xml.etree.ElementTree as ElementTree

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
