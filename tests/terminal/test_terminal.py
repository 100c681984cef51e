"""The process in a terminal that goes, stalls or is suspended; signals, and keys as real bytes."""

from __future__ import annotations

import base64
import re
import signal
import time
from pathlib import Path

import pytest

from archo_tui.base.errors import ArchoError
from archo_tui.cli.console import require_terminal
from tests.support.night import corners
from tests.support.terminal import Start, Terminal, said, until_said
from tests.support.waiting import DEADLINE

SLOW = ("--ros-args", "-p", "feedback_period:=0.1", "-p", "time_scale:=1.0")


INTERRUPTED = """
import os, signal
signal.signal(signal.SIGINT, signal.default_int_handler)  # in the background it may be ignored
class Interrupts:
    def find_spec(self, name, *_):
        if name == "archo_tui.session.session":
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Interrupts())
"""


@pytest.mark.parametrize("end", corners(["SIGHUP"], ["q", "SIGINT", "SIGQUIT"]))  # SIGTERM: below
def test_it_ends_in_order_and_leaves_the_terminal_as_it_was(end: str, start: Start) -> None:
    terminal = start(shows="online")
    if end == "q":
        terminal.write("q")
        code = 0
    else:
        number = getattr(signal, end)
        terminal.kill(number)
        code = 128 + number
    assert terminal.exit_code() == code
    assert "Traceback" not in terminal.text
    assert terminal.is_as_before()


@pytest.mark.parametrize(
    "end", corners(["SIGTERM", "hang up, no signal"], ["hang up", "hang up, nohup"])
)
def test_a_running_goal_is_cancelled_first(end: str, start: Start) -> None:
    no_signal = end == "hang up, no signal"
    terminal = start(
        *SLOW, ignore_hangup=end == "hang up, nohup", controlling=not no_signal, shows="No goal yet"
    )
    terminal.until("max_speed")
    terminal.write("g12\r")
    terminal.until("m left of")
    if end == "SIGTERM":
        terminal.kill(signal.SIGTERM)
    else:
        terminal.hang_up()
    assert terminal.exit_code() == 128 + (signal.SIGTERM if end == "SIGTERM" else signal.SIGHUP)
    assert any("cancelling the goal to shelf 12" in text for text in said()), said()
    assert "cancel: accepted" in said()


def test_a_stray_sigcont_changes_nothing(start: Start) -> None:
    terminal = start(term="xterm-of-next-year")  # a new name is let in
    for _ in range(3):
        terminal.kill(signal.SIGCONT)
    terminal.write("g7\r")
    terminal.until("Arrived at shelf 7")
    terminal.write("\x11")
    assert terminal.exit_code() == 0
    assert terminal.is_as_before()
    assert said("command") == ["go to shelf 7: accepted"]  # not 77: each key came once
    assert terminal.output.count(b"\x1b[?1049h") == 1


def test_it_is_suspended_and_comes_back_with_everything_drawn(start: Start) -> None:
    terminal = start()
    terminal.write("\x1a")
    terminal.until(lambda: terminal.settings() == terminal.before)
    terminal.until("\x1b[?1049l")
    status = Path(f"/proc/{terminal.pid}/status")
    terminal.until(lambda: "State:\tT" in status.read_text())
    terminal.output = b""
    terminal.kill(signal.SIGCONT)
    terminal.until("max_speed")
    terminal.until("1 Battery")
    terminal.write("q")
    assert terminal.exit_code() == 0
    assert terminal.is_as_before()


def test_behind_a_stop_by_sigstop_a_shells_settings_hold_up_no_key(start: Start) -> None:
    terminal = start()
    terminal.kill(signal.SIGSTOP)
    status = Path(f"/proc/{terminal.pid}/status")
    terminal.until(lambda: "State:\tT" in status.read_text())
    terminal.change_settings(terminal.before)  # As a shell does, before and behind `fg`.
    terminal.output = b""
    terminal.kill(signal.SIGCONT)
    terminal.until("1 Battery")
    terminal.write("\x18")
    terminal.until("STOP: confirmed")
    terminal.write("\x11q")
    assert terminal.exit_code() == 0
    assert terminal.is_as_before()


def test_a_terminal_that_stops_reading_costs_no_tick_and_catches_up(start: Start) -> None:
    exact = [f"{name}:={value}" for name, value in (("drain_min", 0.02), ("drain_max", 0.02))]
    words = [word for text in (*exact, "publish_period:=0.05") for word in ("-p", text)]
    terminal = start("--ros-args", *words, "-p", "low_battery_threshold:=0.0")
    terminal.leave_field()
    terminal.write("6el")  # the events on the full screen, with every reading
    terminal.until("Dashboard sees")
    charge = re.compile(r"(\d\d\.\d)%|(\d\d\.\d) %")

    def read() -> float:
        terminal.output = b""
        terminal.until(lambda: charge.search(terminal.text))
        found = charge.search(terminal.text)
        assert found is not None
        return float(found[1] or found[2])

    def draw(seconds: float, *, reading: bool) -> tuple[int, float]:
        """The whole screen ever anew; returns how often, and how long it took."""
        began, toggles = time.monotonic(), 0
        while time.monotonic() < began + seconds:
            terminal.write("e")
            toggles += 1
            end = time.monotonic() + 0.04
            while (left := end - time.monotonic()) > 0:
                if reading:
                    terminal.read(left)
                else:
                    time.sleep(left)
        return toggles, time.monotonic() - began

    before = read()
    _, took = draw(2.0, reading=True)
    first = read()
    toggles, passed = draw(4.0, reading=False)
    terminal.write("1")
    terminal.output = b""

    def shows_the_time() -> bool:
        seconds = (time.localtime(time.time() - ago) for ago in range(3))
        return any(time.strftime("%H:%M:%S", second) in terminal.text for second in seconds)

    terminal.until(shows_the_time)
    assert len(terminal.output) < 3_000 * toggles, "what was not read has all been kept"
    last = read()
    # the ticks go on as while it was read, and are not 0: a busy machine gives each span its share,
    # and what is shown may be some of them old; 0.02 % a tick of 0.05 s at most
    assert (first - last) / passed > 0.25 * min((before - first) / took, 0.02 / 0.05)
    terminal.write("q")
    assert terminal.exit_code() == 0
    assert terminal.is_as_before()


def test_the_end_does_not_wait_for_a_terminal_that_does_not_read(start: Start) -> None:
    terminal = start("--ros-args", "-p", "publish_period:=0.02")
    terminal.leave_field()
    terminal.write("6el")
    for _ in range(30):
        terminal.write("e")
        time.sleep(0.04)
    terminal.kill(signal.SIGTERM)
    assert terminal.exit_code(reading=False) == 128 + signal.SIGTERM
    assert terminal.settings() == terminal.before


FAILS_WHEN_OPENED = """
from archo_tui.screen.commands.help import Help
def fail(self):
    raise ZeroDivisionError("of the help")
Help.body = fail
"""


def test_a_dialog_that_fails_whenever_it_is_opened_does_not_end_the_console(start: Start) -> None:
    far = "-p", "route_length:=1000.0"  # It drives until it is cancelled.
    terminal = start(*SLOW, *far, code=FAILS_WHEN_OPENED)
    terminal.write("g12\r")
    terminal.until("m left of")
    for count in range(1, 5):
        terminal.output = b""
        terminal.leave_field()
        end = time.monotonic() + DEADLINE
        while crashes() < count:  # Directly after a crash a key is to be pressed again.
            assert time.monotonic() < end
            terminal.write("?")
            terminal.read_for(1.0)
        terminal.until("The screen crashed and was restarted; the nodes kept running.")
        terminal.until("in fail")  # of the traceback
        terminal.until("esc close")
        terminal.until("m left of")  # the goal ran on
        terminal.write("\x1b")
    terminal.write("\x03")
    terminal.until("CANCELLED")
    terminal.write("\x11")
    assert terminal.exit_code() == 0
    assert terminal.is_as_before()
    assert "the screen crashed: ZeroDivisionError: of the help" in said()


def crashes() -> int:
    return len(said("screen failure"))


# The second screen waits until the file "go" is there; the first one fails as "?" opens its dialog.
FAILS_AND_WAITS = (
    FAILS_WHEN_OPENED
    + """
import pathlib, time
from archo_tui.screen.app import ArchoApp
made, before = [], ArchoApp.__init__
def waiting(self, *args, **options):
    made.append(self)
    while len(made) > 1 and not pathlib.Path("go").exists():
        pathlib.Path("waits").touch()
        time.sleep(0.01)
    before(self, *args, **options)
ArchoApp.__init__ = waiting
"""
)


@pytest.mark.parametrize(
    ("key", "ended"), [("\x18", "STOP: confirmed"), ("\x03", "shelf 12 cancelled")]
)
def test_what_is_typed_between_a_screen_that_failed_and_the_next_counts(
    key: str, ended: str, start: Start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    far = "-p", "route_length:=1000.0"
    terminal = start(*SLOW, *far, code=FAILS_AND_WAITS)
    terminal.write("g12\r")
    terminal.until("m left of")
    terminal.leave_field()
    terminal.write("?")
    terminal.until((tmp_path / "waits").exists)
    terminal.write(f"r{key}\r")  # The others are not for the screen that follows.
    (tmp_path / "go").touch()
    terminal.until(lambda: any(ended in text for text in said()))
    terminal.until("The screen crashed: press the key again.")
    assert not any("reset encoder" in text for text in said())
    terminal.write("\x11")
    assert terminal.exit_code() == 0
    assert terminal.is_as_before()


FAILS_AT_STOP = """
from archo_tui.screen.app import ArchoApp
before = ArchoApp.close_questions
def failing(self):
    ArchoApp.close_questions = before
    raise ZeroDivisionError("of the dialogs")
ArchoApp.close_questions = failing
"""


def test_a_stop_whose_key_crashes_the_screen_is_sent(start: Start) -> None:
    terminal = start(code=FAILS_AT_STOP)
    terminal.write("\x18")
    terminal.until("The screen crashed and was restarted; the nodes kept running.")
    terminal.until(lambda: "STOP: confirmed" in said())
    sent = "STOP was read while the screen crashed: sent now"
    assert sent in said()
    terminal.write("\x11")
    assert terminal.exit_code() == 0


def test_after_kill_9_the_last_completed_command_is_in_the_journal(start: Start) -> None:
    terminal = start()
    terminal.write("r")
    terminal.until("reset encoder: Encoder reset to zero")
    until_said("reset encoder: Encoder reset to zero")
    terminal.kill(signal.SIGKILL)
    assert terminal.exit_code() == -signal.SIGKILL
    assert said()[-1] == "reset encoder: Encoder reset to zero"


def test_a_command_is_copied_through_the_terminal(start: Start) -> None:
    terminal = start()
    terminal.write("r")
    terminal.until("reset encoder: Encoder reset to zero")
    terminal.leave_field()
    terminal.write("6y")
    command = "ros2 service call /reset_encoder archo_interfaces/srv/ResetEncoder '{}'"
    copied = base64.b64encode(command.encode()).decode()
    terminal.until(lambda: f"\x1b]52;c;{copied}\a".encode() in terminal.output)  # OSC 52
    terminal.write("q")
    assert terminal.exit_code() == 0


HANGING_NODE = """
import threading
from archo_tui.session import session
makers = session._robots_nodes
def with_hanging(use_sim):
    from rclpy.node import Node
    class Hanging(Node):
        def __init__(self, **options):
            super().__init__("hanging", **options)
            self.create_timer(0.01, threading.Event().wait)
    return {**makers(use_sim), "hanging": Hanging}
session._robots_nodes = with_hanging
"""


def test_a_node_that_does_not_stop_is_named_and_the_exit_code_says_so(start: Start) -> None:
    terminal = start(code=HANGING_NODE, shows="online")
    terminal.write("q")
    assert terminal.exit_code() == 1
    assert "/hanging did not stop: its callback does not return" in terminal.text


def test_keys_from_the_first_moment_on_are_obeyed(start: Start) -> None:
    terminal = start(shows="")
    terminal.until("\x1b[?1049h")  # the terminal is taken, nothing is drawn yet
    terminal.write("3?\x1b\x1b[A\x18")
    until_said("STOP: confirmed")
    terminal.write("\x11")
    assert terminal.exit_code() == 0
    assert "Traceback" not in terminal.text


def test_a_signal_in_the_first_moments_leaves_the_terminal_sane(start: Start) -> None:
    terminal = start(shows="")
    terminal.until("\x1b[?1049h")  # the terminal is taken
    terminal.kill(signal.SIGTERM)
    assert terminal.exit_code() == 128 + signal.SIGTERM
    assert terminal.is_as_before()


def test_a_terminal_that_cannot_show_a_screen_is_refused(start: Start) -> None:
    terminal = start(term="dumb", shows="")
    assert terminal.exit_code() == 2
    said = "archo-tui: TERM is dumb: this terminal cannot show a screen, use --plain"
    assert said in terminal.text
    assert b"\x1b[?1049h" not in terminal.output


def test_so_is_one_without_a_name(monkeypatch: pytest.MonkeyPatch) -> None:
    for term, why in (("", "TERM is not set: "), ("unknown", "TERM is unknown: ")):
        monkeypatch.setenv("TERM", term)
        with pytest.raises(ArchoError, match=why):
            require_terminal(None)


def test_the_third_failure_of_the_screen_cancels_the_goal(start: Start) -> None:
    terminal = start(*SLOW, code=FAILS_IN_A_MOVE)
    terminal.write("g12\r")
    assert terminal.exit_code() == 1
    assert any("keeps crashing: cancelling the goal to shelf 12" in text for text in said()), said()
    assert "cancel: accepted" in said()
    assert crashes() == 3


FAIL_ONCE = """
from archo_tui.screen.main import MainScreen
show, failures = MainScreen.show, [0]
def failing(self, view, commands):
    if view.snapshot.goal is not None and not failures[0]:
        failures[0] = 1
        raise ZeroDivisionError("of the screen")
    show(self, view, commands)
MainScreen.show = failing
"""
FAIL_ALWAYS = FAIL_ONCE.replace("view.snapshot.goal is not None and not failures[0]", "True")
GIVES_UP_LATER = """
import pathlib, time
from archo_tui.cli import console
before = console._give_up
async def later(*given):
    pathlib.Path("waits").touch()
    while not pathlib.Path("go").exists():
        time.sleep(0.01)
    await before(*given)
console._give_up = later
"""


def test_a_stop_typed_behind_the_third_failure_is_sent(
    start: Start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    terminal = start(code=FAIL_ALWAYS + GIVES_UP_LATER, shows="")
    terminal.until((tmp_path / "waits").exists)
    terminal.write("\x18")
    (tmp_path / "go").touch()
    assert terminal.exit_code() == 1
    assert "STOP: confirmed" in said()
    assert "the screen keeps crashing: ZeroDivisionError: of the screen" in terminal.text
    assert terminal.is_as_before()


FAILS_IN_A_MOVE = """
from archo_tui.screen.main import MainScreen
show = MainScreen.show
def fail(self, view, commands):
    goal = view.snapshot.goal
    if goal is not None and goal.remaining is not None:
        raise RuntimeError("cannot draw")
    show(self, view, commands)
MainScreen.show = fail
"""


def test_an_interrupt_while_it_is_loaded_ends_it_without_a_word(start: Start) -> None:
    terminal = start(code=INTERRUPTED, fresh=True, shows="")
    assert terminal.exit_code() == -signal.SIGINT
    assert terminal.output == b""


FOREIGN = {
    "COLUMNS": "300",
    "LINES": "100",
    "TEXTUAL_DRIVER": "nowhere:Driver",
    "TEXTUAL_PRESS": "ctrl+x",
    "TEXTUAL_SCREENSHOT": "0",
}


def test_sizes_and_keys_in_the_environment_are_not_the_terminals(start: Start) -> None:
    terminal = start(
        code=f"import os; os.environ |= {FOREIGN!r}", size=(80, 24), fresh=True, shows="● online"
    )
    terminal.until(lambda: "palette" in terminal.text)  # the footer, in the last line of 24
    assert b"STOPPED" not in terminal.output
    terminal.write("q")
    assert terminal.exit_code() == 0


CLEARS = r"""
import os
import rclpy
from rclpy.node import Node


class Clears(Node):
    def __init__(self):
        super().__init__("clears")
        self.create_timer(0.5, lambda: os.system("printf '\\033[2J\\033[Hchild words\\n'"))


def main():
    rclpy.init()
    rclpy.spin(Clears())


if __name__ == "__main__":
    main()
"""


def test_what_a_nodes_child_prints_is_an_event_and_leaves_the_screen_whole(
    here: Path, start: Start
) -> None:
    (here / "clears.py").write_text(CLEARS)
    terminal = start("--only", "--node", "clears.py", shows="child words")
    terminal.until("clears stdout")
    assert b"\x1b[2J\x1b[Hchild" not in terminal.output
    terminal.write("q")
    assert terminal.exit_code() == 0


def test_with_256_colours_no_surface_turns_blue_or_black(start: Start) -> None:
    terminal = start(term="xterm-256color")  # As over SSH and in tmux.
    terminal.write("q")
    assert terminal.exit_code() == 0
    behind = {int(number) for number in re.findall(rb"48;5;(\d+)m", terminal.output)}
    greys, stop, track = {*range(232, 256)}, 124, 16  # A scroll bar is black with all colours, too.
    assert behind & greys
    assert behind <= {*greys, track, stop}


BEGIN, END = "\x1b[200~", "\x1b[201~"
CUT = "The paste was cut off"
RESET, STOP = "reset encoder: Encoder reset to zero", "STOP: confirmed"


@pytest.fixture
def terminal(start: Start) -> Terminal:
    return start()


def ordered_at_the_end(terminal: Terminal) -> list[str]:
    """What was ordered, when it ends by its key."""
    terminal.write("\x11")
    assert terminal.exit_code() == 0
    assert "Traceback" not in terminal.text
    return said("command")


def test_escape_acts_at_once_and_the_next_key_is_a_key(terminal: Terminal) -> None:
    times = []
    for _ in range(5):  # a busy machine may be late now and then
        terminal.output = b""
        terminal.write("?")
        terminal.until("Show all keys")
        terminal.output = b""
        began = time.monotonic()
        terminal.write("\x1b")
        terminal.until("max_speed")  # what was behind the help
        times.append(time.monotonic() - began)
    terminal.write("r")
    until_said(RESET)
    assert min(times) < 0.4  # 0.15, and what it takes to draw
    assert ordered_at_the_end(terminal) == [RESET]


@pytest.mark.parametrize("before", ["", "?", "\x10", "12"])  # in the field, help, the palette
def test_escape_and_a_digit_at_once_lead_to_a_panel(before: str, terminal: Terminal) -> None:
    terminal.write(before)
    terminal.read_for(0.3)
    terminal.write("\x1b8")  # as tmux sends both; it might be alt+8
    terminal.until("MoveToShelf")  # Graph, over the whole screen
    terminal.write("\x1b6\x1b\x18")
    until_said(STOP)
    assert ordered_at_the_end(terminal) == [STOP]


def test_the_keys_of_other_layouts_are_asked_for(terminal: Terminal) -> None:
    assert b"\x1b[<u\x1b[>5u" in terminal.output  # in place of Textual's, under which text is keys
    terminal.write("\x11")
    assert terminal.exit_code() == 0
    assert b"\x1b[<u" in terminal.output


def test_the_rest_of_a_paste_that_stalled_is_text_and_that_is_said(
    terminal: Terminal,
) -> None:
    terminal.leave_field()
    terminal.write("/")
    terminal.until("ype to search")
    terminal.write(f"{BEGIN}whe")
    terminal.until("The paste has not ended: what you type is added to it")
    for char in "el_rsr":
        terminal.write(char)
        terminal.read_for(0.3)
    terminal.write(f"\x18r{END}")
    terminal.write(f"{BEGIN}12")
    terminal.read_for(0.3)
    terminal.write("\x18")
    until_said(STOP, deadline=1.5)  # alone it ends a paste before that stalls
    terminal.until(CUT)
    assert ordered_at_the_end(terminal) == [STOP]


def test_stop_behind_two_thousand_mouse_moves_waits_for_none_of_them(terminal: Terminal) -> None:
    moves = "".join(f"\x1b[<35;{n % 100 + 1};{n % 30 + 1}M" for n in range(2000))
    began = time.monotonic()
    for at in range(0, len(moves), 1000):  # a terminal takes a few thousand bytes at once
        terminal.write(moves[at : at + 1000])
    terminal.write("\x1b[1095::120;5u")  # ctrl+x under a Russian layout
    until_said(STOP)
    assert time.monotonic() - began < 1.5
    assert ordered_at_the_end(terminal) == [STOP]
