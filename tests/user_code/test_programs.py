"""Programs that run beside the console as `python FILE` runs them: `--node FILE`."""

from __future__ import annotations

import asyncio
import io
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest
from archo_interfaces.srv import EmergencyStop
from rclpy.node import Node

import tests.contract.textbook as textbook
from archo_tui.base.errors import ArchoError
from archo_tui.base.handover import Handover
from archo_tui.robot.outcome import Code
from archo_tui.robot.requests.commands import HELD_BY_NOBODY
from archo_tui.robot.state.snapshot import Latch, Life
from archo_tui.session.session import Session
from archo_tui.station.undo import Edit
from archo_tui.user_code import program as hosted_program
from archo_tui.user_code.hosted import HostedThread
from tests.support import chosen
from tests.support.night import corners
from tests.support.shells import reached
from tests.support.waiting import DEADLINE, wait_until
from tests.user_code.support import (
    is_told,
    life,
    release,
    running,
    spinning,
    states,
    stop,
    texts,
    written,
)

pytestmark = [pytest.mark.real_time, pytest.mark.posix]

# As in textbooks; what it does is in said.txt.
TALKER = """
import rclpy
from rclpy.node import Node
from std_srvs.srv import Trigger


def say(text):
    with open("said.txt", "a") as file:
        print(text, file=file)


class Talker(Node):
    def __init__(self):
        super().__init__("talker")
        self.create_service(Trigger, "answer", lambda request, response: response)
        say("{word}")


def main(args=None):
    rclpy.init(args=args)
    node = Talker()
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        say("interrupted")
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
        say("left")


if __name__ == "__main__":
    main()
"""


def talker(word: str = "made") -> Path:
    return written("talker.py", TALKER.replace("{word}", word))


def said() -> list[str]:
    file = Path("said.txt")
    return file.read_text().split() if file.exists() else []


@pytest.fixture(autouse=True)
def _here(here: Path) -> None:
    """Run each test in a folder of its own."""


def test_main_runs_until_it_is_halted_as_by_ctrl_c_and_again() -> None:
    with running(talker()) as session:
        wait_until(lambda: "/talker" in states(session))
        wait_until(lambda: any(n.name == "/talker" for n in session.robot.snapshot.nodes))
        assert life(session) is Life.UP
        wait_until(lambda: states(session)["/talker"].serves == ("/answer",))
        wait_until(lambda: said() == ["made"])
        assert session.host.start_node("/talker") == (Code.REFUSED, "/talker is running")
        assert session.host.stop_node("/talker") == (Code.DONE, "/talker stopped")
        assert said() == ["made", "interrupted", "left"]
        assert life(session) is Life.STOPPED
        assert session.host.start_node("/talker") == (Code.DONE, "/talker started")
        wait_until(lambda: said()[3:] == ["made"])
        wait_until(lambda: life(session) is Life.UP)
    assert said()[3:] == ["made", "interrupted", "left"]


ENDS = """
import sys
import rclpy

rclpy.init()
node = rclpy.create_node("worker")
node.create_timer(0.05, lambda: {what})
rclpy.spin(node)
{then}
"""


def test_a_program_that_shuts_down_ends_alone_and_saving_does_not_run_it_again() -> None:
    worker = written("worker.py", ENDS.format(what="rclpy.shutdown()", then=""))
    with running(talker(), worker) as session:
        wait_until(lambda: life(session, "/worker") is Life.ENDED)
        wait_until(lambda: "worker.py has ended" in texts(session))
        assert life(session) is Life.UP
        worker.write_text(worker.read_text() + "# saved\n")
        said = "worker.py was saved, and has ended: s in Nodes runs it again"
        wait_until(lambda: said in texts(session))
        assert life(session, "/worker") is Life.ENDED
        assert session.host.start_node("/worker").ok
        wait_until(lambda: life(session, "/worker") is Life.ENDED)


@pytest.mark.parametrize(
    ("what", "then", "error"),
    corners(
        [
            ("sys.exit(3)", "", "exit code 3"),
            ("1 / 0", "", "line 7: ZeroDivisionError: division by zero, in: node.create_timer"),
        ],
        [
            ("sys.exit('no map')", "", "no map"),
            ("rclpy.shutdown()", "[][1]", "line 9: IndexError: list index out of range, in: "),
        ],
    ),
)
def test_a_program_that_fails_says_where_and_saving_runs_it(
    what: str, then: str, error: str
) -> None:
    worker = written("worker.py", ENDS.format(what=what, then=then))
    with running(worker) as session:
        wait_until(lambda: life(session, "/worker") is Life.CRASHED)
        state = states(session)["/worker"]
        assert state.error.startswith(error)
        assert ("Traceback" in state.traceback) == ("line" in error)
        wait_until(lambda: is_told(session, f"crashed: {error}"))
        worker.write_text(ENDS.format(what="None", then=""))
        wait_until(lambda: life(session, "/worker") is Life.UP)
        wait_until(lambda: "worker.py was saved: /worker restarted" in texts(session))


FORKS = "if not os.fork():\n    os._exit(0)\nos.wait()\nos._exit(6)"
# It waits for its own child: the process of the tests may have others.
FORK_ENDS = """import os, sys
child = os.fork()
if not child:
    1 / 0
sys.exit(os.waitpid(child, 0)[1] >> 8)
"""
A_FORK = pytest.mark.filterwarnings("ignore:.*multi-threaded:DeprecationWarning")


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("input()", "line 2: EOFError: EOF when reading a line, in: input()"),
        ("import sys; sys.exit(-1)", "exit code 255"),
        ("import os; os._exit(3)", "exit code 3"),
        ("import os, signal; os.kill(os.getpid(), signal.SIGINT); input()", "exit code 130"),
        ("import os, signal; os.kill(os.getpid(), signal.SIGKILL)", "ended by SIGKILL"),
        pytest.param(f"import os\n{FORKS}", "exit code 6", marks=A_FORK),
        pytest.param(FORK_ENDS, "exit code 1", marks=A_FORK),
    ],
)
def test_a_program_that_ends_before_its_first_node_ends_alone(
    text: str, error: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    bad = written("bad.py", f"print('last words', flush=True)\n{text}")
    with running(bad, talker()) as session:
        wait_until(lambda: life(session, "/bad") is Life.CRASHED)
        assert states(session)["/bad"].error == error
        wait_until(lambda: {"last words", f"crashed: {error}"} <= set(texts(session)))
        wait_until(lambda: life(session) is Life.UP)
        wait_until(lambda: said() == ["made"])


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("def", "^bad.py:1: SyntaxError: invalid syntax, in: def"),
        ("# coding: morse", "^bad.py: SyntaxError: unknown encoding: morse"),
    ],
)
def test_a_program_that_is_not_python_is_an_error_at_the_start(text: str, error: str) -> None:
    with pytest.raises(ArchoError, match=error), running(written("bad.py", text)):
        pass


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("x = 1\n", "it ends without a node"),
        ("def", "line 1: SyntaxError: invalid syntax, in: def"),
    ],
)
def test_a_saved_text_that_makes_no_node_leaves_the_old_program_running(
    text: str, fault: str
) -> None:
    with running(talker()) as session:
        wait_until(lambda: said() == ["made"])
        written("talker.py", text)
        said_of_it = f"the saved text does not run: talker.py: {fault}".replace(": line ", ":")
        wait_until(lambda: said_of_it in texts(session))
        assert life(session) is Life.UP
        assert states(session)["/talker"].error == fault
        talker("anew")
        wait_until(lambda: said() == ["made", "interrupted", "left", "anew"])
        assert sum("restarted" in text for text in texts(session)) <= 1


GAIN = TALKER.replace(
    "self.create_service", 'self.declare_parameter("gain", 1.0)\n        self.create_service'
)
SAYS_GAIN = "lambda: say(f\"gain{node.get_parameter('gain').value}\")"
GAIN = GAIN.replace("    try:", f"    node.create_timer(0.1, {SAYS_GAIN})\n    try:")


def test_a_restarted_program_has_the_parameters_that_were_set_and_an_event_names_them() -> None:
    file = written("talker.py", GAIN.replace("{word}", "made"))
    with running(file) as session:
        wait_until(lambda: "gain1.0" in said())
        given = {"gain": 2.5, "speed": 1.0}
        session.host.operator_values = lambda node: given if node == "/talker" else {}
        written("talker.py", GAIN.replace("{word}", "anew"))
        wait_until(lambda: "gain2.5" in said())
        assert "gain1.0" not in said()[said().index("anew") :]
        wait_until(lambda: "set talker gain 2.5 again: it was restarted" in texts(session))
        wait_until(lambda: is_told(session, "speed was not set again: "))


BESIDE = """
from __future__ import annotations
from dataclasses import dataclass, fields
from typing import ClassVar
import rclpy


@dataclass
class Place:
    x: int = 0
    unit: ClassVar[str] = "m"


import words

rclpy.init()
node = rclpy.create_node(words.NAME)
with open("said.txt", "a") as file:
    print(words.NAME, *[field.name for field in fields(Place)], file=file)
rclpy.spin(node)
"""


def test_a_module_beside_a_program_is_its_own_and_restarts_it_when_saved(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(hosted_program, "START_TIME", DEADLINE)
    for folder in ("north", "south"):
        Path(folder).mkdir()
        written(f"{folder}/words.py", f"NAME = '{folder}'\n")
        written(f"{folder}/mine.py", BESIDE)
    with running(Path("north/mine.py"), Path("south/mine.py")) as session:
        # On ROS 2 the second is started while the first still waits for the log to be heard.
        wait_until(lambda: sorted(said()) == ["north", "south", "x", "x"])
        written("north/words.py", "NAME = 'northern'\n")
        wait_until(lambda: said()[4:] == ["northern", "x"])
        wait_until(lambda: "mine.py was saved: /north restarted" in texts(session))
        assert not Path("north/__pycache__").exists()  # Nothing of the reader's is written to.
        # An import is no save.
        assert sum("was saved" in text for text in texts(session)) == 1


def test_no_program_is_started_behind_a_stop_that_is_not_released() -> None:
    with running(talker(), only=False) as session:
        wait_until(lambda: said() == ["made"])  # A STOP before its first node would end it.
        stop(session)
        talker("anew")
        refused = "is not started behind a STOP that is not released: release it first"
        then = "then s in Nodes, twice, starts the saved text"
        wait_until(lambda: f"talker.py was saved, and {refused}, {then}" in texts(session))
        waits = "saved behind a STOP: release it, then s twice starts the saved text"
        assert states(session)["/talker"].error == waits
        assert session.host.stop_node("/talker").ok
        assert session.host.start_node("/talker") == (Code.REFUSED, f"/talker {refused}")
        release(session)
        assert said() == ["made", "interrupted", "left"]
        assert session.host.start_node("/talker").ok
        wait_until(lambda: said() == ["made", "interrupted", "left", "anew"])


def test_one_that_has_crashed_and_is_saved_behind_a_stop_waits_for_a_key() -> None:
    with running(written("talker.py", "1 / 0"), only=False) as session:
        wait_until(lambda: life(session) is Life.CRASHED)
        stop(session)
        talker("mended")
        wait_until(lambda: life(session) is Life.WAITING)
        release(session)
        talker("better")
        saved = "talker.py was saved, and waits for a release: s in Nodes runs it"
        wait_until(lambda: saved in texts(session))
        assert said() == []
        assert session.host.start_node("/talker").ok
        wait_until(lambda: said() == ["better"])


def test_a_program_waits_behind_a_stop_that_was_sent_while_the_console_restarted() -> None:
    with running(talker(), handover=Handover("interfaces were saved", stop=True)) as session:
        refused = "talker.py is not started behind a STOP that is not released: release it first"
        wait_until(lambda: f"{refused}, then s in Nodes starts it" in texts(session))
        assert life(session) is Life.WAITING
        assert not any(node.name == "/talker" for node in session.robot.snapshot.nodes)
        assert said() == []


def test_a_value_set_on_a_programs_node_outlives_a_restart_of_the_console() -> None:
    file = written("talker.py", GAIN.replace("{word}", "made"))
    with running(file) as session:
        wait_until(lambda: "gain1.0" in said())
        session.station.edits.restore([Edit("/talker", {"gain": 1.0}, {"gain": 2.5})])
        left = session.hand_over()
    Path("said.txt").unlink()
    with running(file, handover=left):
        wait_until(lambda: "gain2.5" in said())
        assert "gain1.0" not in said()


WAITS = """
import time
from pathlib import Path

while not Path("go").exists():
    time.sleep(0.02)
"""


@pytest.mark.parametrize("is_released", [False, True])
def test_a_stop_between_the_start_and_the_first_node_ends_a_program(
    is_released: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(hosted_program, "START_TIME", 0.2)
    late = written("late.py", WAITS + TALKER.replace("{word}", "made"))
    with running(late, only=False) as session:
        wait_until(lambda: "release_emergency_stop" in session.robot.snapshot.offered)
        session.robot.stops.register()  # As reading it does.
        stop(session)
        if is_released:
            release(session)
        written("go", "")
        refused = "late.py is not started behind a STOP that is not released: release it first"
        if is_released:
            refused = "late.py is not started: a STOP came, and was released, before it had made a "
            refused += "node"
        wait_until(lambda: f"{refused}, then s in Nodes starts it" in texts(session))
        assert life(session, "/late") is Life.WAITING
        assert said() == []
        if not is_released:
            release(session)
        assert session.host.start_node("/late").ok
        wait_until(lambda: said() == ["made"])


def test_a_stop_while_a_saved_text_begins_leaves_the_one_before_running(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("archo_tui.user_code.watch.FileWatcher.start", lambda self: None)
    with running(talker(), only=False) as session:
        wait_until(lambda: said() == ["made"])
        wait_until(lambda: "emergency_stop" in session.robot.snapshot.offered)
        written("talker.py", "print('begins')" + WAITS + TALKER.replace("{word}", "anew"))
        (program,) = session.host.programs
        reload = threading.Thread(target=session.host.reload, args=[program.file])
        reload.start()
        wait_until(lambda: "begins" in texts(session))
        stop(session)
        written("go", "")
        reload.join()
        assert [*session.host.programs] == [program]
        assert program.state.life is Life.UP
        assert program.state.error.startswith("saved behind a STOP")
        assert said() == ["made"]


@pytest.mark.parametrize("is_slow_to_end", [True, False])
def test_a_program_that_a_stop_keeps_from_running_is_not_called_restarted(
    is_slow_to_end: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("archo_tui.user_code.watch.FileWatcher.start", lambda self: None)
    if not is_slow_to_end:  # Its new text calls no `rclpy.init` in that time.
        monkeypatch.setattr(hosted_program, "IMPORT_TIME", 1.0)
    waits = 'import os, time\n        while not os.path.exists("go"): time.sleep(0.02)\n        '
    slow = TALKER.replace('say("left")', f'{waits}say("left")')
    path = written("talker.py", (slow if is_slow_to_end else TALKER).replace("{word}", "made"))
    with running(path, only=False) as session:
        wait_until(lambda: said() == ["made"])
        wait_until(lambda: "emergency_stop" in session.robot.snapshot.offered)
        anew = TALKER.replace("{word}", "anew")
        written("talker.py", anew if is_slow_to_end else WAITS + anew)
        file = session.host.find("/talker").file  # type: ignore[union-attr]
        reload = threading.Thread(target=session.host.reload, args=[file])
        reload.start()
        before = ["made", "interrupted"] if is_slow_to_end else ["made", "interrupted", "left"]
        wait_until(lambda: said() == before)
        stop(session)
        written("go", "")
        refused = "behind a STOP that is not released: release it first"
        wait_until(lambda: any(refused in text for text in texts(session)))
        reload.join()
        asyncio.run(session.robot.wait_for_events())
        assert not any("restarted" in text for text in texts(session))
        assert "anew" not in said()


MOTOR = """
import rclpy
from archo_interfaces.srv import EmergencyStop
from rclpy.node import Node
from std_srvs.srv import Trigger


class Motor(Node):
    def __init__(self):
        super().__init__("motor_controller")
        self.create_service(EmergencyStop, "emergency_stop", self.agree)
        self.create_service(Trigger, "release_emergency_stop", self.agree)

    def agree(self, request, response):
        response.success = True
        return response


rclpy.init()
rclpy.spin(Motor())
"""


def test_a_stop_whose_program_has_ended_is_released_by_forgetting_it() -> None:
    with running(written("motor.py", MOTOR)) as session:
        robot = session.robot
        wait_until(lambda: "release_emergency_stop" in robot.snapshot.offered)
        assert asyncio.run(robot.emergency_stop()).ok
        assert session.host.stop_node("/motor_controller").ok
        wait_until(lambda: robot.snapshot.stop_held_by_nobody)
        wait_until(lambda: "release_emergency_stop" not in robot.snapshot.offered)
        assert not session.host.start_node("/motor_controller").ok
        assert asyncio.run(robot.release_emergency_stop()) == (Code.DONE, HELD_BY_NOBODY)
        wait_until(lambda: not robot.snapshot.is_stopped)
        assert session.host.start_node("/motor_controller").ok
        wait_until(lambda: "emergency_stop" in robot.snapshot.offered)


def test_a_stop_of_a_node_elsewhere_with_an_ended_programs_name_is_not_forgotten() -> None:
    with running(written("motor.py", MOTOR)) as session:
        robot = session.robot
        wait_until(lambda: "release_emergency_stop" in robot.snapshot.offered)
        assert session.host.stop_node("/motor_controller").ok
        wait_until(lambda: "release_emergency_stop" not in robot.snapshot.offered)
        with running(written("elsewhere.py", MOTOR), domain_id=session.options.domain_id):
            wait_until(lambda: "release_emergency_stop" in robot.snapshot.offered)
            assert asyncio.run(robot.emergency_stop()).ok
        wait_until(lambda: "release_emergency_stop" not in robot.snapshot.offered)
        assert asyncio.run(robot.release_emergency_stop()).code is Code.NOT_OFFERED
        assert robot.snapshot.is_stopped


class StuckMotor(Node):
    """One of ARCHO's own nodes, in a callback that does not return before `may_return`."""

    may_return, is_in_callback = threading.Event(), threading.Event()

    def __init__(self, **options: Any) -> None:
        super().__init__("motor_controller", **options)
        self.create_service(EmergencyStop, "emergency_stop", lambda _, response: response)
        self.create_timer(0.01, self.block)

    def block(self) -> None:
        self.is_in_callback.set()
        self.may_return.wait(DEADLINE)


def test_a_stuck_node_of_the_robot_is_not_replaced_by_a_program(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(HostedThread.stop, "__defaults__", (0.3, 0.1))
    monkeypatch.setattr("archo_tui.user_code.host.WAY_TIMEOUT", 0.3)
    StuckMotor.may_return.clear()
    text = f"import pathlib, time\nwhile not pathlib.Path('go').exists(): time.sleep(0.01)\n{MOTOR}"
    makers = {"only": False, "node_makers": (StuckMotor,)}
    with running(written("mine.py", text), **makers) as session:  # type: ignore[arg-type]
        robot = session.robot
        try:
            assert StuckMotor.is_in_callback.wait(DEADLINE)
            written("go", "")
            wait_until(lambda: is_told(session, "crashed: ARCHO's own motor_controller is stuck"))
            why = "ARCHO's own motor_controller is stuck: its callback still runs"
            assert states(session)["/mine"].error == f"{why}, so it is not replaced"
            wait_until(lambda: f"crashed: {why}, so it is not replaced" in texts(session))
            assert life(session, "/motor_controller") is Life.STUCK
            assert session.host.start_node("/motor_controller").code is Code.REFUSED
            assert not asyncio.run(robot.emergency_stop()).ok
            assert robot.snapshot.open_stop is not None
            assert asyncio.run(robot.give_up_stop()).ok
        finally:
            StuckMotor.may_return.set()
        wait_until(lambda: session.host.start_node("/mine").ok)
        wait_until(lambda: [h.life for h in states(session).values()] == [Life.UP])
        assert states(session)["/motor_controller"].file == "mine.py"
        wait_until(lambda: asyncio.run(robot.emergency_stop()).ok)


def test_a_stop_reaches_a_service_that_a_running_program_offers_later() -> None:
    waits = 'super().__init__("motor_controller")\n        while not Path("go").exists():\n'
    waits += "            time.sleep(0.02)"
    text = "import time\nfrom pathlib import Path\n"
    text += MOTOR.replace('super().__init__("motor_controller")', waits)
    with running(written("slow.py", text)) as session:
        robot = session.robot
        wait_until(lambda: "/motor_controller" in states(session))
        assert asyncio.run(robot.emergency_stop()).code is Code.NOT_OFFERED
        written("go", "")
        wait_until(lambda: robot.snapshot.latch is Latch.HELD)


def test_a_stop_reaches_the_first_program_while_a_slow_one_is_still_waited_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(hosted_program, "START_TIME", DEADLINE)
    stopped = MOTOR.replace(
        "response.success", 'open("stopped", "w").close()\n        response.success'
    )
    motor = written("motor.py", stopped)
    waits = 'open("waiting", "w").close()\n' + WAITS
    slow = written("slow.py", waits + TALKER.replace("{word}", "made"))
    begun: list[Session] = []

    def operate() -> None:
        with running(motor, slow, remote=True) as session:
            begun.append(session)

    starting = threading.Thread(target=operate)
    starting.start()
    try:
        wait_until(Path("waiting").exists)
        with reached() as console:
            console.send(b'{"id": 1, "words": ["stop"]}\n')
        wait_until(Path("stopped").exists)
        assert not begun
    finally:
        written("go", "")
        starting.join()
    assert said() == []  # It is not started behind the STOP.


SECOND = """
first = Node("first")
while not Path("go").exists():
    rclpy.spin_once(first, timeout_sec=0.05)
rclpy.spin(Motor())
"""


def test_a_second_node_that_replaces_the_motor_makes_the_stop_uncertain() -> None:
    head = MOTOR.replace("import rclpy\n", "from pathlib import Path\nimport rclpy\n", 1)
    text = head.replace("rclpy.spin(Motor())\n", SECOND)
    with running(written("two.py", text), only=False) as session:
        robot = session.robot
        wait_until(lambda: "/first" in states(session))
        wait_until(lambda: "emergency_stop" in robot.snapshot.offered)
        assert asyncio.run(robot.emergency_stop()).ok
        wait_until(lambda: robot.snapshot.latch is Latch.HELD)
        written("go", "")
        wait_until(lambda: robot.snapshot.latch is Latch.UNCERTAIN)


LISTINGS = Path(textbook.__file__).parent


def test_a_client_of_the_textbook_ends_when_its_service_has_answered() -> None:
    with running(LISTINGS / "reset_client.py", LISTINGS / "reset_service.py") as session:
        wait_until(lambda: life(session, "/reset_client") is Life.ENDED)
        if chosen.ENGINE == "embedded":  # On ROS 2 it has left before its log is discovered.
            wait_until(lambda: "Result: True, Encoder reset to zero" in texts(session))


def test_a_program_lasts_as_long_as_the_threads_that_it_started() -> None:
    late = """
def end():
    Path("said.txt").write_text("shut")
    rclpy.shutdown()

threading.Thread(target=rclpy.spin, args=(node,)).start()
node.create_timer(1.0, end)
Path("over").touch()
raise SystemExit
"""
    with running(spinning("late", late)) as session:
        wait_until(Path("over").exists)
        assert life(session, "/late") is Life.UP
        wait_until(lambda: life(session, "/late") is Life.ENDED)
        assert said() == ["shut"]


def test_an_error_in_a_thread_of_a_program_is_an_event_and_no_crash() -> None:
    raises = 'threading.Thread(target=lambda: 1 / 0, name="work").start()'
    with running(spinning("thrower", raises)) as session:
        wait_until(lambda: any("ZeroDivisionError" in text for text in texts(session)))
        wait_until(lambda: life(session, "/thrower") is Life.UP)  # Its node may come later.


def test_the_threads_of_a_program_end_with_it(capsys: pytest.CaptureFixture[str]) -> None:
    loops = """
def loop():
    while True:
        time.sleep(0.02)

threading.Thread(target=loop, name="a loop").start()
threading.Thread(target=loop, name="a loop", daemon=True).start()
"""
    with running(spinning("looper", loops)) as session:
        wait_until(lambda: life(session, "/looper") is Life.UP)
        assert session.host.stop_node("/looper").ok
        wait_until(lambda: "a loop" not in [thread.name for thread in threading.enumerate()])
    assert capsys.readouterr().err == ""


# It goes on whatever is raised in it, until there is a file called `end`.
SLEEPS = """
while not Path("end").exists():
    try:
        Path("said.txt").write_text("asleep")
        time.sleep(1.5)
    except BaseException:
        pass
raise SystemExit
"""


def test_a_program_that_does_not_end_is_ended_by_force(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hosted_program, "START_TIME", 0.2)
    monkeypatch.setattr(HostedThread.stop, "__defaults__", (0.3, 0.5))
    with running(spinning("sleeper", SLEEPS)) as session:
        wait_until(lambda: said() == ["asleep"])  # else an interrupt before the loop ends it
        outcome = session.host.stop_node("/sleeper")
        if chosen.ENGINE == "embedded":  # A thread cannot be ended while it sleeps.
            assert outcome.code == Code.TIMEOUT
            assert life(session, "/sleeper") is Life.STUCK
            assert not any("sleeper" in n.get_name() for n in session.context._graph.nodes)
        else:
            assert outcome == (Code.DONE, "/sleeper stopped")
        written("end", "")
        program = session.host.find("/sleeper")
        assert program is not None
        wait_until(lambda: not program._thread.is_alive())


IN_A_PROCESS = pytest.mark.skipif(
    chosen.ENGINE == "embedded", reason="there what it starts is a child of the console"
)
LEAVES = 'subprocess.Popen(["sleep", "1000"])\nraise SystemExit'


@IN_A_PROCESS
def test_a_program_has_ended_though_what_left_its_group_holds_its_output() -> None:
    is_unknown = '"20"], start_new_session=True, env={}'
    text = LEAVES.replace('"1000"]', is_unknown) + "(5)"
    with running(spinning("parent", text)) as session:
        wait_until(lambda: life(session, "/parent") is Life.CRASHED, deadline=10.0)


DAEMON = """
import subprocess
child = subprocess.Popen(["sleep", "1000"], start_new_session=True)
open("child.txt", "w").write(str(child.pid))
"""


def has_child_ended() -> bool:
    child = Path("/proc", Path("child.txt").read_text(), "stat")
    return not child.exists() or ") Z " in child.read_text()


@IN_A_PROCESS
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells whose child a daemon is")
def test_a_daemon_that_a_program_has_started_ends_with_it() -> None:
    with running(written("parent.py", DAEMON)) as session:
        wait_until(lambda: life(session, "/parent") is Life.ENDED)
        assert has_child_ended()


@IN_A_PROCESS
def test_a_child_that_cannot_be_ended_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("archo_tui.user_code.child.kill_marked", lambda _: [7, 11])
    with running(written("parent.py", "print(1)")) as session:
        text = "has ended, but not what it has started: end process 7, 11 yourself"
        wait_until(lambda: text in texts(session))


@IN_A_PROCESS
def test_a_program_ends_with_a_console_that_is_killed() -> None:
    file = talker()
    # Elsewhere what has left its group is not known.
    daemon = DAEMON if sys.platform == "linux" else DAEMON.replace(", start_new_session=True", "")
    file.write_text(daemon + file.read_text())
    words = ["--engine", "ros2", "--only", "--node", "talker.py", "--plain", "--no-remote"]
    domain = {"ROS_DOMAIN_ID": str(chosen.next_domain())}
    console = subprocess.Popen(
        [sys.executable, "-m", "archo_tui", *words],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        env={**os.environ, **domain},
    )
    with console:
        wait_until(lambda: said() == ["made"])
        console.send_signal(signal.SIGKILL)
    wait_until(lambda: said() == ["made", "interrupted", "left"])
    wait_until(has_child_ended)


def test_a_stop_typed_while_programs_begin_lets_none_of_them_make_a_node(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(hosted_program, "START_TIME", DEADLINE)
    counted: list[bool] = []

    def stop_was_typed() -> bool:
        if counted:
            Path("go").touch()
        if counted or not Path("begun").exists():
            return False
        counted.append(True)
        return True

    begins = f"open('begun', 'w').close()\n{WAITS}"
    file = written("talker.py", begins + TALKER.replace("{word}", "made"))
    with running(file, stop_was_typed=stop_was_typed, only=False) as session:
        assert counted
        wait_until(lambda: life(session) is Life.WAITING)
        assert "STOP was read while the console restarted: sent now" in texts(session)
        assert said() == []
