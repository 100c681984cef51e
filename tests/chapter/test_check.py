"""`archo-tui check`: what learners write, right and wrong, and what each of them is told.

A text in `share/learners.txt` begins with what is expected of it: `# ok: 1 2` are the checks that
pass, `# not ok 3: WORDS` is one that fails and words of its hint, `# skip 1: WORDS` names what is
there instead, `# exit 2: WORDS` is all that is said of a file that cannot be hosted, `# says:
WORDS` how a line begins, `# nothing` that nothing was checked. HERE is the file and the line that
ends in `# here`. What is not named is skipped, but for the last check, which passes.
"""

from __future__ import annotations

import re
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import archo_bringup
import pytest

import tests.contract.textbook as textbook
from archo_tui.cli import main
from tests.support import chosen, clock, learners
from tests.support.learners import LEARNERS

LISTINGS = Path(textbook.__file__).parent
OURS = Path(archo_bringup.__file__).parent
RESET = "reset_encoder sets the encoder to zero, and answers True, 'Encoder reset to zero'"
LAST = 11  # no node crashes
_SHORT = 0.05  # s; what sleeps in a constructor, before there is anybody to move the clock


@pytest.fixture(autouse=True)
def _moved(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The clock of the test is the checker's, the nodes', and that of what sleeps in them."""
    monkeypatch.setattr("archo_tui.user_code.host.END_TIMEOUT", 0.3)
    monkeypatch.setenv("ROS_PYTHON_CHECK_FIELDS", "1")
    # On ROS 2 a program is a process of its own, which must find the checker.
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setenv("ROS_DOMAIN_ID", str(chosen.next_domain()))
    for loaded in list(sys.modules.values()):
        if "ros_python_check_fields" in vars(loaded):
            vars(loaded)["ros_python_check_fields"] = "1"
    if clock.current is None:
        yield
        return
    from rclpy.executors import Executor, MultiThreadedExecutor

    virtual, over, real = clock.current, threading.Event(), time.sleep
    sleeping: set[threading.Condition] = set()

    def sleep(seconds: float) -> None:
        if seconds < _SHORT or not threading.current_thread().name.startswith("/"):
            real(seconds)
            return
        until = virtual.monotonic_ns() + int(seconds * 1e9)
        condition = threading.Condition()
        sleeping.add(condition)
        with condition:
            while virtual.monotonic_ns() < until and not over.is_set():
                virtual.wait(condition, lambda: True, until)
        sleeping.discard(condition)

    monkeypatch.setattr(time, "sleep", sleep)

    def is_idle(executor: Any) -> bool:
        """As the clock sees a program's threads by their names, once they have begun."""
        working = sum(future.running() for future in executor._running)
        waiting = [f for f in executor._running if not (f.done() or f.running())]
        has_free_thread = working < executor._executor._max_workers
        return Executor._is_idle(executor) and not (waiting and has_free_thread)

    monkeypatch.setattr(MultiThreadedExecutor, "_is_idle", is_idle)
    monkeypatch.setattr("archo_tui.session.session.Clock", lambda: virtual)
    yield
    over.set()
    for condition in list(sleeping):
        with condition:
            condition.notify_all()


class Expected:
    """What is said of a file."""

    def __init__(self, name: str) -> None:
        lines, text = LEARNERS[name]
        places = {
            mark.upper(): f"{name}.py:{number}"
            for mark in ("here", "there")
            for number, line in enumerate(text.splitlines(), 1)
            if line.endswith(f"  # {mark}")
        }
        self.passes: set[int] = set()
        self.failures: dict[int, list[str]] = {}
        self.skips: dict[int, str] = {}
        self.refused = ""
        self.says: list[str] = []
        self.nothing = "# nothing" in lines
        for line in lines:
            found = re.fullmatch(r"# (ok|not ok|skip|exit|says) ?(\d*): (.+)", line)
            if found is None:
                continue
            what, number, said = found.groups()
            words = re.sub(r"\b(T?HERE)\b", lambda place: places[place[0]], said)
            if what == "ok":
                self.passes |= {int(word) for word in words.split()}
            elif what == "not ok":
                self.failures.setdefault(int(number), []).append(words)
            elif what == "skip":
                self.skips[int(number)] = words
            elif what == "says":
                self.says.append(words)
            else:
                self.refused = words


@pytest.mark.filterwarnings("ignore:MultiThreadedExecutor is used with a single thread")
@pytest.mark.parametrize("name", LEARNERS)
def test_a_learner_is_told(
    name: str, here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if name == "stop_shuts_rclpy_down" and chosen.ENGINE == "ros2":
        pytest.skip("there the answer leaves before the node ends")
    expected = Expected(name)
    if expected.refused.endswith("BatteryMonitor.__init__ "):
        limits = {"embedded": 2.0, "ros2": 5.0}
        monkeypatch.setattr("archo_tui.cli.check._START_TIME", limits)
        monkeypatch.setattr("archo_tui.user_code.program.START_TIME", limits[chosen.ENGINE])
    monkeypatch.setattr(threading, "excepthook", threading.__excepthook__)  # and not pytest's
    code = main(["check", "--engine", chosen.ENGINE, str(learners.write(name, here))])
    said = capsys.readouterr()
    if expected.refused:
        assert code == 2
        assert said.out == ""
        assert expected.refused in said.err
        assert len(said.err.splitlines()) == 1
        return
    assert said.err == ""
    first, *lines, plan = said.out.splitlines()
    assert (first, plan) == ("TAP version 13", f"1..{LAST}")
    passes, skips, failures = set(), dict[int, str](), dict[int, str]()
    number = 0
    for line in lines:
        found = re.match(r"(ok|not ok) (\d+) - [^#]+(# SKIP .+)?$", line)
        if found is None:
            assert line.startswith("# "), line
            if number in failures:
                failures[number] += f"{line}\n"
            continue
        number = int(found[2])
        if found[1] == "not ok":
            failures[number] = ""
        elif found[3]:
            skips[number] = found[3]
        else:
            passes.add(number)
    assert passes - {LAST} == expected.passes, said.out
    assert failures.keys() == expected.failures.keys(), said.out
    for number, hints in expected.failures.items():
        for words in hints:
            assert words in failures[number], said.out
    for number, words in expected.skips.items():
        assert words in skips[number]
    assert all(any(line.startswith(words) for line in lines) for words in expected.says), said.out
    assert ("nothing was checked" in said.out) == expected.nothing
    assert code == (1 if failures or expected.nothing else 0)


def check(capsys: pytest.CaptureFixture[str], *files: Path) -> tuple[int, list[str]]:
    """The exit code, and the lines that are not skipped."""
    code = main(["check", "--engine", chosen.ENGINE, *map(str, files)])
    first, *lines, plan = capsys.readouterr().out.splitlines()
    assert (first, plan) == ("TAP version 13", "1..11")
    return code, [line for line in lines if "# SKIP" not in line]


def test_the_robots_own_nodes_pass(capsys: pytest.CaptureFixture[str]) -> None:
    names = ("battery_monitor", "dashboard", "motor_controller")
    code, lines = check(capsys, *(OURS / f"{name}.py" for name in names))
    assert code == 0, lines
    assert [line[:6].rstrip(" -") for line in lines] == [f"ok {n}" for n in range(1, 12)]


def test_a_listing_is_asked_for_what_it_offers_and_shows_only(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, lines = check(capsys, LISTINGS / "reset_service.py")
    assert (code, lines[0]) == (0, f"ok 9 - {RESET}")
    assert [line[:6] for line in lines] == ["ok 9 -", "ok 11 "]
    listing = (LISTINGS / "reset_service.py").read_text()
    (tmp_path / "reset.py").write_text(re.sub(r".*self\.encoder_ticks.*\n", "", listing))
    _, lines = check(capsys, tmp_path / "reset.py")
    assert lines[0] == "ok 9 - reset_encoder answers True, 'Encoder reset to zero'"


@pytest.mark.skipif(chosen.ENGINE != "embedded", reason="there interfaces are built by colcon")
def test_a_type_of_the_learners_own_needs_the_fields_of_the_chapters(tmp_path: Path) -> None:
    package = tmp_path / "own_interfaces"
    (package / "srv").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>own_interfaces</name></package>")
    (package / "srv" / "ResetEncoder.srv").write_text("---\nbool success\n")
    listing = (LISTINGS / "reset_service.py").read_text().replace("archo_interf", "own_interf")
    (tmp_path / "reset.py").write_text(re.sub(r".*response\.message.*\n", "", listing))
    command = [sys.executable, "-m", "archo_tui", "check", "reset.py", "--interfaces", "."]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode == 1, done.stderr
    lacks = "you serve a own_interfaces/srv/ResetEncoder without message; the chapter's is"
    assert re.search(rf"^# reset.py:\d+: {lacks}", done.stdout, re.MULTILINE), done.stdout


def test_a_crash_leaves_the_other_checks_and_a_node_of_the_same_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    listing = (LISTINGS / "reset_service.py").read_text().replace("        return response\n", "")
    stop = 'self.create_service(ResetEncoder, "emergency_stop", ResetStop())'
    listing = listing.replace("self.encoder_ticks = 15420", stop)
    stops = "\n\nclass ResetStop:\n    def __call__(self, request, response):\n"
    stops += "        response.success = True\n        return response\n"
    (tmp_path / "reset.py").write_text(listing.replace("\n\nclass ", f"{stops}\n\nclass ", 1))
    files = [LISTINGS / "motor_parameters.py", tmp_path / "reset.py"]
    code, lines = check(capsys, *files, LISTINGS / "battery_subscriber.py")
    assert code == 1
    passed = [int(line.split()[1]) for line in lines if line.startswith("ok ")]
    assert passed == [4, 5, 6, 10], lines
    hint = f"# {tmp_path}/reset.py:18: TypeError: reset_callback returns nothing: end it with"
    assert sum(line.startswith(hint) for line in lines) == 2, lines


def test_an_interrupt_is_said(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("archo_tui.user_code.check.checker.Checker.check_crashes", interrupt)
    code = main(["check", "--engine", chosen.ENGINE, str(LISTINGS / "motor_parameters.py")])
    said = capsys.readouterr()
    assert code == 1
    assert said.out.splitlines()[-1] == "Bail out! interrupted"
    assert said.err == "archo-tui: interrupted: not all was checked\n"


PAGE = Path(__file__).parents[2] / "docs" / "chapter.md"


@pytest.mark.parametrize(
    ("section", "listings"),
    [
        ("3.2", ["battery_publisher"]),
        ("3.3", ["battery_subscriber"]),
        ("3.4", ["reset_service"]),
        ("3.5", ["move_action_server"]),
        ("3.6", ["motor_parameters"]),
    ],
)
def test_the_page_quotes_for_each_section_what_check_says(
    section: str, listings: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    _, lines = check(capsys, *(LISTINGS / f"{name}.py" for name in listings))
    said = [re.sub(r"^# .*?\.py:", "# ", line) for line in lines]
    text = PAGE.read_text().partition(f"### {section} ")[2].partition("\n##")[0]
    quoted = re.findall(r"^(?:ok|not ok|#) .*$", text, re.MULTILINE)
    assert quoted
    for line in quoted:
        line = re.sub(r"^# \w+\.py:", "# ", line)
        assert any(of.startswith(line) for of in said), line


def test_the_page_quotes_for_a_launch_file_what_check_says(
    capsys: pytest.CaptureFixture[str],
) -> None:
    launch_file = PAGE.parents[1] / "nodes" / "launch" / "archo_comms.launch.py"
    assert main(["check", str(launch_file)]) == 0
    _, *lines, plan = capsys.readouterr().out.splitlines()
    assert plan == "1..5"
    assert "\n".join(lines) in PAGE.read_text().partition("### 3.7 ")[2]
