"""README and docs/: links lead somewhere, commands are parsed, listings loaded, walks walked."""

from __future__ import annotations

import ast
import json
import re
import shlex
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import Mock

import jsonschema
import pytest

from archo_tui import cli
from archo_tui.base.yaml_text import bounded_yaml
from archo_tui.cli.options import (
    SUBCOMMANDS,
    OneLineErrorParser,
    add_subcommand_arguments,
    console_parser,
    split_line,
    split_ros_args,
)
from archo_tui.client import shell as verbs_from_shells
from archo_tui.robot_file.load import default_path, load
from archo_tui.robot_file.reserved import VERB_FLAGS, VERB_VALUES
from archo_tui.ros.embedded import parameter_files
from archo_tui.screen.commands import keymap, registry
from archo_tui.screen.commands.base import readable_key
from archo_tui.screen.commands.replay import replay_commands
from archo_tui.station import conditions
from archo_tui.verbs import verbs
from archo_tui.verbs.verb import YES, named
from tests import generated
from tests.generated import ROOT, SCHEMA, anchor
from tests.support import chosen
from tests.support.archo import ARCHO, FORMS
from tests.support.console import console
from tests.support.plain import operated, plain
from tests.support.script import shell

README, CONTRIBUTING = ROOT / "README.md", ROOT / "CONTRIBUTING.md"
DOCS = sorted((ROOT / "docs").glob("*.md"))
OTHERS = ("CONTRIBUTING.md", "THIRD_PARTY.md", "CHANGELOG.md", "SECURITY.md")
PAGES = [README, *map(ROOT.joinpath, OTHERS), *DOCS]
PROJECT = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
PACKAGES = (".", "archo_tui", "archo_tui/screen", "archo_tui/ros/embedded")
VERBS = verbs(ARCHO, FORMS)
each_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))


class Page(NamedTuple):
    """What stands in a page."""

    prose: str  # without its blocks
    blocks: list[tuple[str, str]]  # language and text of each; indented ones have no language
    code: list[str]  # what stands in backticks within prose

    @property
    def rows(self) -> Iterator[dict[str, str]]:
        """The rows of all its tables, by their heads."""
        for table in re.findall(r"(?:^\|.*\n)+", self.prose, re.MULTILINE):
            lines = [re.split(r" ?\| ?", line.strip("| ")) for line in table.splitlines()]
            for cells in lines[2:]:
                yield dict(zip(lines[0], [*cells, "", "", ""], strict=False))


@cache
def read(page: Path) -> Page:
    text = page.read_text(encoding="utf-8")
    blocks = re.findall(r"^```(\w*)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    text = re.sub(r"^```\w*\n.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    indented = r"(?<=\n\n)(?:    .*\n+)+"
    blocks += [
        ("", re.sub(r"^    ", "", found, flags=re.M)) for found in re.findall(indented, text)
    ]
    prose = re.sub(indented, "", text)
    return Page(prose, blocks, re.findall(r"`([^`\n]+)`", prose))


def codes(cell: str) -> list[str]:
    """What stands in backticks."""
    return re.findall(r"`([^`]+)`", cell)


# where things are


def test_readme_is_one_page() -> None:
    lines = README.read_text(encoding="utf-8").splitlines()
    assert len(lines) <= 90
    assert [line for line in lines if len(line) >= 110] == []
    venv = "python3 -m venv .venv && .venv/bin/pip install -q "
    commands = [line for _, text in read(README).blocks for line in text.splitlines()]
    assert commands[0].startswith("git clone https://github.com/archo-tui/archo-tui && ")
    assert [line for line in commands if line.startswith("python3")] == [
        f"{venv}. && .venv/bin/archo-tui",
        f"{venv}-e '.[test]' && .venv/bin/pytest",
    ]


def test_every_page_is_in_the_index() -> None:
    linked = re.findall(r"\]\((\w+\.md)\)", (ROOT / "docs" / "README.md").read_text())
    assert sorted(linked) == [page.name for page in DOCS if page.name != "README.md"]


@each_page
def test_every_link_leads_to_a_file_and_a_heading(page: Path) -> None:
    for target in re.findall(r"\]\(([^)\s]+)\)", read(page).prose):
        if target.startswith("https://"):
            continue
        name, _, heading = target.partition("#")
        file = page.parent / name if name else page
        assert file.exists(), target
        if heading:
            found = re.findall(r"^#+ (.*)$", file.read_text(encoding="utf-8"), re.MULTILINE)
            assert heading in map(anchor, found), target


@each_page
def test_every_file_that_is_named_exists(page: Path) -> None:
    folders = r"(archo_tui|tests|docs|nodes|interfaces|config|typings|\.ci)/"
    for code in read(page).code:
        if re.match(rf"{folders}[\w./-]*$", code):
            assert (ROOT / code).exists(), code
        elif re.match(r"[a-z_]+/[a-z_]+\.py$", code):
            assert any((ROOT / place / code).exists() for place in PACKAGES), code


def test_every_folder_of_the_architecture_exists() -> None:
    page = read(ROOT / "docs" / "architecture.md")
    (folders,) = (text for _, text in page.blocks if text.startswith("archo_tui/ "))
    for name in re.findall(r"\b([a-z_]+/)", folders):
        rooms = (ROOT / "archo_tui", *(ROOT / "archo_tui").glob("*/"))
        places = (ROOT, *rooms, ROOT / "tests", ROOT / "config")
        assert any((place / name).is_dir() for place in places), name
    named_here = set(re.findall(r"\b([a-z_]+)/", folders))
    names = {path.parent.name for path in (ROOT / "archo_tui").glob("*/__init__.py")}
    assert names <= named_here


def test_every_package_that_others_wrote_is_in_the_notice() -> None:
    notice = (ROOT / "THIRD_PARTY.md").read_text(encoding="utf-8")
    for package in (ROOT / "archo_tui" / "ros" / "embedded" / "share").iterdir():
        assert f"`{package.name}`" in notice, package.name
    licences = re.search(r"^license-files = (.*)$", PROJECT, re.MULTILINE)
    assert licences is not None
    assert '"THIRD_PARTY.md"' in licences[1]


# what is typed


def commands(page: Path) -> Iterator[list[str]]:
    """The words behind each `archo-tui` that somebody may type."""
    blocks = [text for language, text in read(page).blocks if language != "json"]
    lines = [line for text in blocks for line in text.splitlines()]
    lines += [code for code in read(page).code if code.startswith("archo-tui ")]
    for line in lines:
        for found in re.finditer(r"(?<![\w.-])archo-tui(?![\w./-])([^|&;)#`]*)", line):
            yield [word for word in shlex.split(found[1]) if word != "..."]


def parse_command(words: list[str]) -> None:
    """Raises, or exits with another code than 0, for words that the command line does not take."""
    own, _ = split_ros_args(words)
    parser = console_parser()
    of_console, command = split_line(own, parser)
    parser.parse_args(of_console)
    name, *rest = command or [""]
    if name in SUBCOMMANDS:
        made = OneLineErrorParser(name, "")
        add_subcommand_arguments(made, name)
        made.parse_intermixed_args(rest)
    elif name and name not in ("VERB", "COMMAND"):
        parse_verb(verbs_from_shells.CommandLine([name, *rest]).rest)


def parse_verb(words: list[str]) -> None:
    """Raises for a verb that does not exist, or takes other values."""
    word, *rest = words
    if word not in ("wait", "help", "quit"):
        named(VERBS, word).values([given for given in rest if given != YES])


@each_page
def test_every_command_is_one(page: Path) -> None:
    for words in commands(page):
        try:
            parse_command([word for word in words if word != "--help"])
        except Exception as error:
            raise AssertionError(f"archo-tui {shlex.join(words)}: {error}") from error


@each_page
def test_what_is_installed_launched_or_run_by_python_exists(page: Path) -> None:
    lines = "\n".join([*(text for _, text in read(page).blocks), *read(page).code])
    for extra in re.findall(r"\.\[(\w+)\]", lines):
        assert re.search(rf"^{extra} = \[$", PROJECT, re.MULTILINE), extra
    for launched in re.findall(r"\w+\.launch\.py", lines):
        assert (ROOT / "nodes" / "launch" / launched).is_file(), launched
    for module in re.findall(r"python3? -m ((?:tests|archo_tui)[.\w]*)", lines):
        path = ROOT / module.replace(".", "/")
        assert path.with_suffix(".py").is_file() or (path / "__main__.py").is_file(), module


def options() -> set[str]:
    made: list[Any] = [console_parser()]
    for name in SUBCOMMANDS:
        made.append(OneLineErrorParser("", ""))
        add_subcommand_arguments(made[-1], name)
    found = {option for parser in made for option in parser._option_string_actions}
    found |= {argument.name for verb in VERBS.values() for argument in verb.arguments}
    return found | {YES, *VERB_FLAGS, *VERB_VALUES}


@each_page
def test_every_option_that_is_named_exists(page: Path) -> None:
    others = {
        "--config-settings",
        "--end-to-end",
        "--night",
        "--update-snapshots",
    }  # of pip and pytest
    for code in read(page).code:
        if code.startswith("--"):
            assert code.split()[0] in options() | others, code


@each_page
def test_every_verb_of_a_table_is_one(page: Path) -> None:
    for row in read(page).rows:
        for code in codes(row.get("type", "")):
            parse_verb(shlex.split(code))


def test_the_lines_of_the_page_are_commands_of_plain() -> None:
    language, lines = read(ROOT / "docs" / "plain.md").blocks[0]
    assert language == ""
    for line in lines.splitlines():
        parse_verb(shlex.split(line))


@each_page
def test_every_key_that_is_named_is_one(page: Path) -> None:
    there: Any = Mock(file=ARCHO)  # The player.
    every = (*registry(ARCHO), *replay_commands(there, verbs(ARCHO, {})))
    known = {readable_key(command.key).replace("^", "ctrl+") for command in every}
    known |= {"tab", "esc", "p", "P", "t"}  # p, P, t: in the dialog of a topic
    for row in read(page).rows:
        for code in codes(row.get("key", "")) if "value" not in row else ():
            assert code in known, code
    if page.stem != "first_drive":  # what it presses is pressed
        for code in read(page).code:
            if code not in ("x", "y") and re.fullmatch(
                r"(ctrl|shift|alt)\+\w+|f\d+|[A-Za-z?+/]", code
            ):
                assert code in known, code


@pytest.mark.parametrize("words", [["--version"], ["keys"], ["journal"], ["completions", "bash"]])
def test_what_is_quick_runs(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert any(words == found for page in PAGES for found in commands(page))
    assert cli.main(words) == 0
    assert capsys.readouterr().out


def test_the_script_of_the_page_drives_the_robot() -> None:
    (line,) = (text for _, text in read(ROOT / "docs" / "plain.md").blocks if "printf" in text)
    fast = "--ros-args -p time_scale:=75.0 -p feedback_period:=0.05"
    done = shell(line.replace("archo-tui --plain", f"archo --plain {fast}"))
    assert done.returncode == 0, done
    assert "Arrived at shelf 7" in done.stdout.decode()


def seconds_left(text: str) -> float:
    """Return the time left that a screen shows, in s; 0 for none."""
    found = re.search(r"about ([\d.]+) s left", text)
    return float(found[1]) if found else 0.0


async def test_the_first_drive_goes_as_it_is_told() -> None:
    page = read(ROOT / "docs" / "first_drive.md")
    (_, first), *_ = page.blocks
    names = {"esc": "escape", "/": "slash", ".": "full_stop"}
    left = dict[str, float]()  # By the words of the step: the seconds that are left then.
    async with console(*first.split()[2:], size=(80, 24)) as op:  # the least that the page names
        for row in page.rows:
            await op.press(*(names.get(key, key) for key in codes(row["press"])))
            for text in codes(row["you see"]):
                if "is gone" in row["you see"]:
                    await op.until(lambda text=text: text not in op.text)  # type: ignore[misc]
                else:
                    await op.until(text, deadline=60.0)
            if "time that is left grows" in row["you see"]:
                before = max(left.values())
                await op.until(lambda: seconds_left(op.text) > 1.3 * before)  # noqa: B023
            elif "MOVING to 3" in row["you see"]:
                await op.until(lambda: seconds_left(op.text))
                left["MOVING to 3"] = seconds_left(op.text)


# listings


def programs(found: Any) -> Iterator[dict[str, Any]]:
    """The parts of a configuration that start a program."""
    if isinstance(found, dict):
        if "command" in found:
            yield found
        for value in found.values():
            yield from programs(value)


@each_page
def test_every_configuration_starts_a_command_that_is_one(page: Path) -> None:
    for text in [text for language, text in read(page).blocks if language == "json"]:
        begun = list(programs(json.loads(text)))
        assert begun
        for program in begun:
            assert program["command"] == "archo-tui"
            assert program["args"][0] in SUBCOMMANDS
            parse_command(program["args"])


def listings(language: str, word: str) -> list[Any]:
    """Every block of a language with that word in it, named by its page."""
    return [
        pytest.param(text, id=page.stem)
        for page in [README, *DOCS]
        for found, text in read(page).blocks
        if found == language and word in text
    ]


@pytest.mark.parametrize("text", listings("python", "battery_monitor"))
def test_a_node_of_the_chapter_passes_its_check(text: str, tmp_path: Path) -> None:
    file = tmp_path / "battery.py"
    file.write_text(text)
    done = shell(f"archo check --engine {chosen.ENGINE} {file}")
    assert done.returncode == 0, done
    assert b"\nok 1 - battery_level is a std_msgs/msg/Float32\n" in done.stdout


@pytest.mark.parametrize("text", listings("python", "Trigger"))
async def test_a_node_of_a_page_is_hosted_and_called(text: str, tmp_path: Path) -> None:
    file = tmp_path / "lamp.py"
    file.write_text(text)
    code, said = await plain("call blink\n", node_files=[file], only=True)
    assert code == 0, said
    assert "call blink: success true\n" in said


@pytest.mark.parametrize("text", listings("yaml", "version:"))
def test_a_robot_file_of_a_page_is_read(text: str, tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(text)
    assert load(file).goals[0].noun == "shelf"
    assert schema_faults(text) == []


@pytest.mark.parametrize("text", listings("yaml", "ros__parameters"))
def test_a_parameter_file_of_a_page_is_read(text: str, tmp_path: Path) -> None:
    file = tmp_path / "params.yaml"
    file.write_text(text)
    assert parameter_files.read(file)


@pytest.mark.parametrize("text", listings("yaml", "stop: f"))
def test_a_keymap_of_a_page_is_read(text: str, tmp_path: Path) -> None:
    file = tmp_path / "keymap.yaml"
    file.write_text(text)
    keys, others = keymap.load_keymap(file, registry(ARCHO))
    assert (keys["stop"], others) == ("f6", "")


# what is made from the code, and what stands in it


def test_what_is_made_from_the_code_is_as_the_code_is() -> None:
    for path, text in generated.files().items():
        stale = path.read_text(encoding="utf-8") != text
        assert not stale, f"{path.name} is stale: python -m tests.generated"


def schema_faults(text: str) -> list[str]:
    """What an editor marks in a robot file."""
    validator = jsonschema.Draft202012Validator(generated.schema())
    return [error.message for error in validator.iter_errors(bounded_yaml.load(text))]


FILES = [*default_path().parent.glob("*.yaml"), *(ROOT / "tests" / "robots").glob("*.yaml")]


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_the_robot_files_fit_the_schema(file: Path) -> None:
    jsonschema.Draft202012Validator.check_schema(generated.schema())
    text = file.read_text(encoding="utf-8")
    assert schema_faults(text) == []
    booleans = re.findall(r"(?:^|[{,])\s*(?:off|on|yes|no):", text, re.MULTILINE)
    assert booleans == []  # as an editor takes such a key
    if file.parent == default_path().parent:
        assert text.startswith(f"# yaml-language-server: $schema={SCHEMA.name}\n")


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("version: 1", "version: 2"),
        ("battery:", "batery:"),
        ("percentage: percentage", "percentage: [a]"),
        ("otherwise: 20.0", "otherwise: soon"),
        ("    title: Go to shelf\n", ""),
        ("ask: moving", "ask: sometimes"),
        ("stop: {service: emergency_stop, ", "stop: {"),
    ],
)
def test_a_mistake_in_a_robot_file_is_marked_by_the_schema(right: str, wrong: str) -> None:
    text = default_path().read_text(encoding="utf-8")
    assert right in text
    assert schema_faults(text.replace(right, wrong, 1))


@cache
def spoken() -> str:
    """Every text in the code, `…` for what is filled in."""
    found = []
    for folder in (ROOT / "archo_tui", ROOT / "nodes"):
        for file in folder.rglob("*.py"):
            nodes = [*ast.walk(ast.parse(file.read_text(encoding="utf-8")))]
            docstrings = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
            for node in nodes:
                if id(node) in docstrings:
                    continue
                if isinstance(node, ast.Constant) and isinstance(node.value, str):
                    found.append(node.value)
                elif isinstance(node, ast.JoinedStr):
                    parts = (getattr(part, "value", None) for part in node.values)
                    found.append("".join(p if isinstance(p, str) else "…" for p in parts))
    return "\n".join(found)


def test_the_words_of_the_pages_are_said_by_the_code() -> None:
    said = spoken()
    for page, column in (("alarms", "says"), ("troubleshooting", "words")):
        rows = [row for row in read(ROOT / "docs" / f"{page}.md").rows if column in row]
        assert len(rows) > 10
        for words in (words for row in rows for words in codes(row[column])):
            pattern = r"[^\n]*?".join(map(re.escape, words.split("…")))
            assert re.search(pattern, said), words


def test_every_alarm_has_its_row_with_priority_and_delay() -> None:
    rows = [row for row in read(ROOT / "docs" / "alarms.md").rows if "alarm" in row]
    told = [(codes(row["alarm"])[0], codes(row["priority"])[0], row["after"]) for row in rows]
    assert told == [
        (kind.name, kind.priority.value, f"{kind.delay:g} s" if kind.delay else "")
        for kind in conditions.KINDS
    ]


def test_every_invariant_of_stop_is_checked_in_the_explorations() -> None:
    explorations = (ROOT / "tests" / "robot").glob("explore*.py")
    explored = "".join(path.read_text() for path in explorations)
    rows = (ROOT / "docs" / "stop.md").read_text().split("; invariant")[1:]
    named = [words for row in rows for words in re.findall(r"\*([^*|]+)\*", row.split("|")[0])]
    assert len(named) >= 15
    assert [words for words in named if f'"{words}"' not in explored] == []


def test_the_functions_of_the_tour_are_in_its_files() -> None:
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    stops = re.findall(r"\]\(\.\./(\S+\.py)\): `(\w+)`", page)
    assert len(stops) == 7
    for file, name in stops:
        assert f"def {name}(" in (ROOT / file).read_text(encoding="utf-8"), (file, name)


ROS2_ROWS = list(read(ROOT / "docs" / "ros2_commands.md").rows)
ROS2_LINES = [
    line for row in ROS2_ROWS for line in codes(row["line"]) if not line.startswith("archo-tui ")
]
NOT_ARCHOS = ("lifecycle bt_navigator activate",)  # tests/robots/test_field_page.py types it


def test_each_ros2_command_of_the_table_has_something_that_does_the_same() -> None:
    assert len(ROS2_ROWS) >= 20
    for row in ROS2_ROWS:
        (command,) = codes(row["with ros2"])
        assert command.startswith("ros2 ")
        assert row["on the screen"] or row["line"]


async def test_each_line_of_the_table_does_what_it_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    async with operated() as person:
        for line in ROS2_LINES:
            if line not in NOT_ARCHOS:
                person.type(f"{line}\n")
                await person.is_read()
        code = await person.end()
    assert "failed:" not in person.said, person.said
    assert code == 0
    assert "archo_interfaces/msg/BatteryStatus" in person.said
    assert "max_speed 0.5" in person.said
    assert (tmp_path / "params.yaml").exists()
