"""A node whose constructor takes its time: others are started meanwhile, and it when it is made."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from rclpy.node import Node

from archo_tui.robot.outcome import Code
from archo_tui.robot.state.snapshot import Hosted, Life
from archo_tui.session import Session
from archo_tui.session_options import Options
from tests.support import chosen
from tests.support.console import console
from tests.support.waiting import wait_until

pytestmark = pytest.mark.real_time

ASKER = """
import rclpy
from rclpy.node import Node
from std_srvs.srv import Trigger


class Asker(Node):
    def __init__(self):
        super().__init__("asker")
        client = self.create_client(Trigger, "blink")
        while not client.wait_for_service(timeout_sec=0.1):
            pass
        future = client.call_async(Trigger.Request())
        rclpy.spin_until_future_complete(self, future)
        self.answer = future.result().message
"""
LAMP = """
from rclpy.node import Node
from std_srvs.srv import Trigger


class Lamp(Node):
    def __init__(self):
        super().__init__("lamp")
        self.create_service(Trigger, "blink", self.blink)

    def blink(self, request, response):
        response.message = "on"
        return response
"""
# serves a STOP, and is made when there is a file called `go`
MOTOR = """
import time
from pathlib import Path
from rclpy.node import Node
from std_srvs.srv import Trigger


class Motor(Node):
    def __init__(self):
        super().__init__("motor")
        self.said = []
        self.declare_parameter("speed", 1.0)
        self.create_service(Trigger, "halt", self.halt)
        self.create_timer(0.01, lambda: self.said.append("drives"))
        while not Path("go").exists():
            time.sleep(0.01)  # here

    def halt(self, request, response):
        self.said.append("halted")
        response.success = True
        return response
"""


def written(name: str, text: str) -> Path:
    file = Path(name)
    file.write_text(text)
    return file


@contextmanager
def hosting(*files: Path, **options: Any) -> Iterator[Session]:
    """A session whose nodes are waited for as long as a constructor without a wait may take."""
    given = {"only": True, **options}
    session = Session(
        Options(chosen.ENGINE, domain_id=chosen.next_domain(), node_files=files, **given), None
    )
    session.start()
    try:
        yield session
    finally:
        assert session.close() == []


@pytest.fixture(autouse=True)
def _impatient(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    limit = 0.3 if chosen.ENGINE == "embedded" else 3.0
    monkeypatch.setattr("archo_tui.hosting.hosted_node.CONSTRUCTION_TIME", limit)


def state(session: Session, name: str) -> Hosted:
    return next(hosted for hosted in session.host.states() if hosted.name == name)


def texts(session: Session) -> list[str]:
    return [event.text for event in session.robot.snapshot.events]


def is_up(session: Session, name: str) -> Callable[[], bool]:
    return lambda: state(session, name).life is Life.UP


def test_a_constructor_is_answered_by_a_node_of_a_later_file() -> None:
    with hosting(written("asker.py", ASKER), written("lamp.py", LAMP)) as session:
        wait_until(is_up(session, "/asker"))
        asker = next(h for h in session.host.nodes if h.name == "/asker").node
        assert asker.answer == "on"  # type: ignore[attr-defined]
        late = "asker.py:11: Asker.__init__ waits for other nodes, in: while not client."
        wait_until(lambda: any(text.startswith(late) for text in texts(session)))


def test_a_constructor_that_waits_for_others_holds_up_nobody(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("archo_tui.hosting.hosted_node.CONSTRUCTION_TIME", 10.0)
    with hosting(written("lamp.py", LAMP), written("asker.py", ASKER)) as session:
        wait_until(is_up(session, "/asker"))
        waits = "asker.py:14: Asker.__init__ waits for other nodes, in: rclpy.spin_until_future"
        wait_until(lambda: any(text.startswith(waits) for text in texts(session)))


def test_what_it_waits_for_is_said_with_the_line_until_it_is_stopped() -> None:
    with hosting(written("asker.py", ASKER)) as session:
        waiting = state(session, "/asker")
        assert waiting.life is Life.STARTING
        assert waiting.error.startswith("line 11, in: while not client.wait_for_service(")
        assert session.host.start_node("/asker") == (Code.REFUSED, "/asker is starting")
        assert session.host.stop_node("/asker") == (Code.DONE, "/asker stopped")
        assert state(session, "/asker").life is Life.STOPPED
        wait_until(lambda: "/asker" not in [n.name for n in session.robot.snapshot.nodes])
        assert session.host.start_node("/asker").ok
        assert state(session, "/asker").life is Life.STARTING


def test_one_that_takes_its_time_is_a_warning_with_the_line() -> None:
    with hosting(written("motor.py", MOTOR)) as session:
        late = re.compile(r"motor\.py:1[56]: Motor\.__init__ did not return within 0?\.?3 s, in: ")
        wait_until(lambda: any(late.match(text) for text in texts(session)))
        Path("go").touch()
        wait_until(is_up(session, "/motor"))


async def test_on_the_screen_s_stops_it() -> None:
    async with console(node_files=[written("asker.py", ASKER)], only=True, wait=False) as op:
        await op.until("○ asker")
        await op.until("starting: line 11, in: while not")
        await op.press("5", "s")
        await op.until("○ asker            stopped by you")


def test_one_that_spins_for_good_in_its_constructor_ends_with_the_console() -> None:
    spinning = LAMP.replace(
        "\n    def blink", "        import rclpy\n        rclpy.spin(self)\n\n    def blink"
    )
    with hosting(written("lamp.py", spinning), written("asker.py", ASKER)) as session:
        wait_until(is_up(session, "/asker"))  # which the lamp answers
        assert state(session, "/lamp").life is Life.STARTING


def test_what_one_serves_that_spins_in_its_constructor_is_known_and_goes_with_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    spinning = LAMP.replace(
        "\n    def blink", "        import rclpy\n        rclpy.spin(self)\n\n    def blink"
    )
    with hosting(written("lamp.py", spinning), written("asker.py", ASKER)) as session:
        wait_until(is_up(session, "/asker"))  # which the lamp answers
        assert state(session, "/lamp").serves == ("/blink",)
        gone: list[str] = []
        monkeypatch.setattr(session.host, "_on_end", gone.extend)
        assert session.host.stop_node("/lamp").ok
        assert gone == ["/blink"]


def test_one_that_fails_late_has_crashed_and_names_its_line() -> None:
    fails = MOTOR.replace("\n    def halt", "        1 / 0\n\n    def halt")
    with hosting(written("motor.py", fails)) as session:
        assert state(session, "/motor").life is Life.STARTING
        Path("go").touch()
        wait_until(lambda: state(session, "/motor").life is Life.CRASHED)
        assert state(session, "/motor").error == (
            "line 17: ZeroDivisionError: division by zero, in: 1 / 0"
        )
        wait_until(lambda: any("crashed: line 17: " in text for text in texts(session)))
        assert session.host.start_node("/motor").text.startswith("motor.py:17: ZeroDivision")


def test_behind_a_stop_it_is_told_that_before_it_does_anything(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with hosting(written("motor.py", MOTOR)) as session:
        told: list[str] = []
        monkeypatch.setattr(session.host, "_early_stop_request", lambda: ("/halt", {}))
        monkeypatch.setattr(session.host, "_on_early_stop", told.append)
        motor = session.host.nodes[0]
        Path("go").touch()
        wait_until(lambda: "drives" in getattr(getattr(motor, "node", None), "said", ()))
        assert motor.node.said[:2] == ["halted", "drives"]  # type: ignore[attr-defined]
        assert told == ["/motor"]


def test_behind_a_stop_it_is_told_that_before_its_constructor_spins_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    spins = MOTOR.replace("time.sleep(0.01)", "rclpy.spin_once(self)").replace(
        "import time", "import rclpy"
    )
    with hosting(written("motor.py", spins)) as session:
        monkeypatch.setattr(session.host, "_early_stop_request", lambda: ("/halt", {}))
        assert session.host.stop_node("/motor").ok
        assert session.host.start_node("/motor").ok
        motor = session.host.nodes[0]
        assert motor.state.life is Life.STARTING
        (node,) = motor._begun
        wait_until(lambda: node.said.count("drives") > 3)  # type: ignore[attr-defined]
        assert node.said[0] == "halted"  # type: ignore[attr-defined]
        assert node.said.count("halted") == 1  # type: ignore[attr-defined]


def test_it_has_the_parameters_that_were_set_before_its_file_was_saved() -> None:
    Path("go").touch()
    with hosting(written("motor.py", MOTOR)) as session:
        Path("go").unlink()
        file = session.host.nodes[0].file
        assert file is not None
        session.host.operator_values = lambda _: {"speed": 3.0}
        session.host.reload(file)
        assert state(session, "/motor").life is Life.STARTING
        Path("go").touch()
        wait_until(lambda: "drives" in getattr(getattr(motor(session), "node", None), "said", ()))
        assert motor(session).node.get_parameter("speed").value == 3.0


def motor(session: Session) -> Any:
    return session.host.nodes[0]


class Motor(Node):
    """One of the robot's own."""

    def __init__(self, **options: Any) -> None:
        super().__init__("motor", **options)


def test_it_takes_the_place_of_one_of_the_robots_own_of_its_name() -> None:
    unnamed = MOTOR.replace(
        'super().__init__("motor")', "wait()\n" + 8 * " " + "super().__init__('motor')"
    )
    waits = "\n\ndef wait():\n    while not Path('go').exists():\n        time.sleep(0.01)\n"
    with hosting(written("mine.py", unnamed + waits), only=False, node_makers=(Motor,)) as session:
        assert [hosted.name for hosted in session.host.nodes] == ["/mine", "/motor"]
        Path("go").touch()
        wait_until(lambda: [h.name for h in session.host.states()] == ["/motor"])
        assert session.host.nodes[0].file is not None


def test_a_session_that_does_not_begin_leaves_no_thread_of_a_node() -> None:
    import threading

    from archo_tui.errors import ArchoError

    lamp, broken = written("lamp.py", LAMP), written("broken.py", LAMP.replace('"lamp"', "1 / 0"))
    with pytest.raises(ArchoError, match=r"broken\.py:8: ZeroDivisionError"), hosting(lamp, broken):
        pass
    assert not any("/lamp" in thread.name for thread in threading.enumerate())
