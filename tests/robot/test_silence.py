"""A robot that says too little for its period to be known: when it counts as silent."""

from __future__ import annotations

import re
import threading
from collections.abc import Iterable, Iterator
from functools import partial
from typing import Any

import pytest
from archo_interfaces.msg import MotorStatus
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Float32

from archo_tui.robot.messages.period import MessageRate, Period, is_silent
from archo_tui.robot.state.graph import node_states
from tests.support import clock
from tests.support.clock import seconds
from tests.support.plain import Typed, operated
from tests.support.quiet import until, while_passes

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Teller(Node):
    """Says its charge at the start, and again each so many s, if any."""

    def __init__(self, again: float = 0.0, qos: Any = 10, **options: Any) -> None:
        super().__init__("teller", **options)
        self.battery = self.create_publisher(Float32, "battery_level", qos)
        self.first = self.create_timer(1.5, self.begin)  # when the console has found it
        if again:
            self.create_timer(again, self.tell)

    def begin(self) -> None:
        self.first.cancel()
        self.tell()

    def tell(self) -> None:
        self.battery.publish(Float32(data=42.0))


async def state(person: Typed, after: float) -> str:
    """What `status` says about so many s after the battery was last heard."""
    robot, before = person._plain._station.robot, len(person.said)
    await until(lambda: seconds() > (robot.snapshot.battery.received or seconds()) + after)
    person.type("status\n")
    await person.until("\ngoal ")
    return person.said[before:]


@pytest.mark.waits
async def test_what_is_heard_once_is_old_after_90_s_though_its_node_is_there() -> None:
    if clock.current is None:
        pytest.skip("it takes as long in real time")
    async with operated(Teller) as person:
        assert re.search(r"battery GOOD, 42.0 %, 8\d s ago\n", await state(person, 88.0))
        assert "CONTACT LOST" not in person.said
        assert "battery GOOD, 42.0 %, old, " in await state(person, 91.0)
        assert "alarm unacknowledged: CONTACT LOST for " in person.said


@pytest.mark.parametrize(
    ("maker", "watched"),
    [(partial(Teller, 10.0), 60.0), (partial(Teller, qos=LATCHED), 120.0)],
    ids=["each 10 s", "latched"],
)
@pytest.mark.waits
async def test_who_speaks_rarely_or_says_what_holds_is_not_silent(
    maker: Any, watched: float
) -> None:
    async with operated(maker) as person:
        # in real time long enough for one silence of 10 s
        await while_passes(15.0 if clock.current is None else watched)
        person.type("status\n")
        await person.until("\ngoal ")
        assert re.search(r"battery GOOD, 42.0 %(, \d+ s ago)?\n", person.said)
        assert "CONTACT LOST" not in person.said


class Hanging(Node):
    """Drives, and hangs soon after its parameter was set."""

    def __init__(self, hang: threading.Event, **options: Any) -> None:
        super().__init__("hanging", **options)
        self.hang, self.left = hang, 0
        self.declare_parameter("max_speed", 0.8)
        self.motors = self.create_publisher(MotorStatus, "motor_status", 10)
        self.create_timer(0.1, self.tell)

    def tell(self) -> None:
        self.motors.publish(MotorStatus(moving=True))
        self.left -= self.get_parameter("max_speed").value != 0.8
        if self.left < 0:
            with clock.stuck():
                self.hang.wait(30)


async def test_a_node_that_hangs_after_a_set_is_missed_as_soon_as_any_other() -> None:
    hang = threading.Event()
    async with operated(partial(Hanging, hang)) as person:
        robot = person._plain._station.robot
        await until(lambda: robot.snapshot.motion.period and robot.snapshot.parameters)
        person.type("set hanging max_speed 1.5\n")
        # On a busy machine it may hang before its new value was heard.
        await person.until("set hanging max_speed 1.5: ")
        began = seconds()
        await person.until("alarm unacknowledged: CONTACT LOST for ")
        assert seconds() - began < 5.0
        clock.release(hang)


@pytest.mark.pure
@pytest.mark.parametrize(
    ("measured", "old", "new", "known"),
    [
        (1.0, 1.0, 5.0, 5.0),  # the parameter is the period
        (1.0, 1.0, 900.0, 10.0),  # and is believed up to a limit
        (4.0, 4.0, 0.5, 4.0),  # the publisher may wait for the end of the old one
        (0.2, 0.8, 1.5, 0.2),
        (1.0, None, 5.0, 1.0),  # of another node
        (1.0, True, False, 1.0),
        (1.0, 1.0, 0.0, 1.0),
    ],
)
def test_a_period_is_known_until_it_is_measured_anew(
    measured: float, old: Any, new: Any, known: float
) -> None:
    period = Period().with_message_at(7.0).with_message_at(7.0 + measured).measured_again(old, new)
    assert period.seconds == pytest.approx(known)
    assert period.with_message_at(20.0).with_message_at(23.0).seconds == 3.0


def bursts(count: int, each: float, pause: float, total: float = 300.0) -> Iterator[float]:
    """Yield the times (s) of messages that come in bursts, until `total`."""
    at = 0.0
    while at < total:
        yield from (at + each * number for number in range(count))
        at += each * (count - 1) + pause


@pytest.mark.pure
@pytest.mark.parametrize(
    ("times", "lost"),
    [
        (bursts(5, 0.2, 9.0, total=1.0), 15.0),  # It may have been a burst.
        (bursts(1, 0.0, 0.2), 2.5),
        (bursts(1, 0.0, 1.0), 3.0),
        (bursts(1, 0.0, 10.0), 30.0),
        (bursts(1, 0.0, 60.0), 180.0),
        (bursts(10, 0.01, 10.0), 30.0),
        (bursts(20, 0.1, 14.0), 42.0),
        (bursts(3, 1.0, 8.0), 24.0),
        (bursts(5, 0.2, 2.0), 6.0),
    ],
    ids=[
        "first words",
        "5 Hz",
        "1 Hz",
        "10 s",
        "60 s",
        "10 a burst",
        "20 a burst",
        "slow bursts",
        "short pauses",
    ],
)
def test_silence_is_judged_by_what_is_typical_and_noticed(
    times: Iterator[float], lost: float
) -> None:
    period, last = Period(), next(times)
    period = period.with_message_at(last)
    for at in times:
        assert not is_silent(last, period.typical, at, period.grace), at
        period, last = period.with_message_at(at), at
    assert not is_silent(last, period.typical, last + lost - 0.1, period.grace)
    assert is_silent(last, period.typical, last + lost + 0.1, period.grace)


def lost(times: Iterable[float]) -> tuple[Period, list[float]]:
    """Return the period, and when messages came behind a silence, in s."""
    period, last, found = Period(), 0.0, list[float]()
    for at in times:
        if is_silent(last, period.typical, at, period.grace):
            found.append(round(at, 1))
        period, last = period.with_message_at(at), at
    return period, found


def regular(at: float, count: int) -> list[float]:
    """Return the times (s) of messages at 5 Hz from a time on, without the first."""
    return [at + 0.2 * number for number in range(1, count)]


def restarts() -> list[float]:
    """Return the times (s) of a robot whose starts take 10 s, and that runs as long as it does."""
    times = [0.0]
    for runs in (40.0, 15.0, 90.0, 20.0):
        times += regular(times[-1], round(runs / 0.2))
        times.append(times[-1] + 10.0)
    return [*times, *regular(times[-1], 100)]


def slower(factor: float) -> list[float]:
    """Return the times (s) of a link that grows slower and slower."""
    times = [0.0, *regular(0.0, 100)]
    for number in range(8):
        times.append(times[-1] + 4.0 * factor**number)
    return times


def crashes() -> list[float]:
    """Return the times (s) of a node that crashes while the robot boots, and runs at last."""
    times = [*bursts(15, 0.2, 5.0, total=60.0)]
    assert lost(times)[0].typical == pytest.approx(5.0)
    return [*times, *regular(times[-1], 200)]


@pytest.mark.pure
@pytest.mark.parametrize(
    ("times", "missed", "typical"),
    [
        ([*bursts(20, 0.1, 60.0)], 1, 60.0),  # The robot may have died.
        ([*bursts(100, 0.1, 5.0)], 3, 5.0),
        (restarts(), 4, 0.2),
        (slower(1.5), 8, 0.2),
        (slower(2.0), 8, 0.2),
        ([0.0, 0.2, 0.4, 3.4, *regular(3.4, 60)], 0, 0.2),
        (crashes(), 3, 0.2),
    ],
    ids=["far bursts", "long bursts", "restarts", "slower", "much slower", "a hiccup", "crashes"],
)
def test_a_silence_is_missed_until_it_is_typical(
    times: list[float], missed: int, typical: float
) -> None:
    period, silences = lost(times)
    assert len(silences) == missed
    assert period.typical == pytest.approx(typical, abs=0.11)


def with_outages(*outages: float, each: float) -> list[float]:
    """Return the times (s) of regular messages with outages near the start, and 25 s after them."""
    times = [0.0, each]
    for outage in outages:
        times += [times[-1] + outage, times[-1] + outage + each]
    return [*times, *(times[-1] + each * number for number in range(1, round(25 / each)))]


@pytest.mark.pure
@pytest.mark.parametrize(
    ("outages", "each", "allowed"),
    [((7.0, 9.0), 1.0, 3.0), ((7.0, 9.0), 0.2, 2.5), ((9.0, 7.5, 8.6), 0.5, 2.5)],
)
def test_outages_while_a_robot_boots_do_not_dull_its_silence(
    outages: tuple[float, ...], each: float, allowed: float
) -> None:
    times = with_outages(*outages, each=each)
    period, _ = lost(times)
    for after, is_lost in ((allowed - 0.1, False), (allowed + 0.1, True)):
        assert is_silent(times[-1], period.typical, times[-1] + after, period.grace) is is_lost


def test_a_node_has_the_rate_of_what_it_still_says() -> None:
    fast, slow = (MessageRate(0.0) for _ in range(2))
    for number in range(1, 201):
        fast = fast.with_message_at(number / 20)
    for number in range(1, 21):
        slow = slow.with_message_at(float(number))
    (base,) = node_states(["/base"], {}, [("/base", fast), ("/base", slow)]).values()
    assert (base.heard, base.rate) == (20.0, 1.0)
    assert (base.is_silent(22.0), base.is_silent(24.0)) == (False, True)
    (wheel,) = node_states(["/wheel"], {"/wheel": 12.0}, [("/wheel", fast)]).values()
    assert wheel.heard == 12.0
    assert wheel.rate == pytest.approx(20.0)
    assert wheel.is_silent(15.0)


async def test_a_console_that_was_suspended_with_its_nodes_has_lost_nobody() -> None:
    if clock.current is None:
        pytest.skip("real time passes for all")
    async with operated() as person:
        robot = person._plain._station.robot
        await while_passes(5.0)
        assert robot.snapshot.battery.period == 1.0
        clock.current.suspend(6.0)
        assert person._plain._station.tick() == []  # the first to go on, before the nodes
        await while_passes(5.0)
        assert "alarm" not in person.said


async def test_what_holds_is_old_when_its_node_has_left() -> None:
    async with operated(partial(Teller, qos=LATCHED)) as person:
        await until(lambda: person._plain._station.robot.snapshot.battery.received)
        person.type("halt teller\n")
        left = seconds()
        await person.until("alarm unacknowledged: CONTACT LOST for ")
        assert seconds() - left < 30.0  # long before what may still be sent is missed
