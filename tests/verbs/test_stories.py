"""Each verb's story in `--plain`: what is typed, and what is said."""

from __future__ import annotations

import asyncio
import re
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from depot_interfaces.action import Fibonacci
from rcl_interfaces.srv import ListParameters
from rclpy.action import ActionServer
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

from archo_tui.robot.outcome import data_of
from archo_tui.robot.state.readings import Pose
from archo_tui.robot.state.snapshot import OpenStop, Snapshot
from archo_tui.session.session import _robots_nodes
from archo_tui.verbs.alarms import Alarms
from tests.robots.rover import Counting
from tests.support import clock
from tests.support.archo import ARCHO
from tests.support.clock import NOW
from tests.support.console import LONG
from tests.support.plain import Typed, operated, plain, typing
from tests.support.quiet import until
from tests.support.stand_in import Made, StandIn
from tests.support.states import NORMAL, STATES
from tests.support.stub import StandingClock, StubRobot, stub_station

SPEED = "motor_controller max_speed"


async def test_a_parameter_is_shown_with_type_range_and_star() -> None:
    code, said = await plain(f"get {SPEED}\nset {SPEED} 0.5\nget /{SPEED}\n")
    assert code == 0, said
    assert f"\n{SPEED} is 0.5, was 0.8 at the start, double, allowed 0.05 .. 2\n" in said
    assert said.startswith(f"{SPEED} is 0.8, double, allowed 0.05 .. 2\n")


async def test_parameters_are_saved_and_loaded_and_undone(here: Path) -> None:
    typed = f"set {SPEED} 0.5\nsave 'a b.yaml'\nset {SPEED} 0.6\nload 'a b.yaml' --yes\nundo\n"
    code, said = await plain(f"{typed}save 'a b.yaml' --yes\n")
    assert code == 0, said
    assert "YOU console: save parameters: saved to a b.yaml" in said
    assert f"set {SPEED} 0.5: max_speed is 0.5, was 0.6" in said
    assert "\n1 changed\n" in said
    assert f"set {SPEED} 0.6: max_speed is 0.6, was 0.5" in said
    assert "max_speed: 0.6" in (here / "a b.yaml").read_text()


def known(**options: Any) -> Node:
    return Node("known", **options)


def without_services(**options: Any) -> Node:
    return Node("without", start_parameter_services=False, **options)


def mute(**options: Any) -> Node:
    """A node that never answers which parameters it has."""
    node = Node("mute", start_parameter_services=False, **options)

    async def never(_: Any, response: Any) -> Any:
        await Future(executor=node.executor)
        return response

    node.create_service(ListParameters, "mute/list_parameters", never)
    return node


async def test_a_node_without_parameter_services_is_named_when_the_others_are_saved(
    here: Path,
) -> None:
    code, said = await plain("save a.yaml\nget without x\n", known, without_services)
    assert code == 1
    assert "WARN console: not saved, without has no parameter services\n" in said
    assert "failed: save" not in said  # It has nothing that could be saved.
    assert "failed: get: /without has no parameter services\n" in said
    assert "known:" in (here / "a.yaml").read_text()
    assert "not saved, known" not in said


async def test_a_node_that_has_not_answered_is_no_node_without_that_parameter(here: Path) -> None:
    (here / "b.yaml").write_text("mute:\n  ros__parameters:\n    x: 1\n    y: 2\n")
    lines = ("set mute x 2", "get mute x", "params", "save a.yaml", "load b.yaml", "set known x 2")
    code, said = await plain("\n".join((*lines, "")), known, mute)
    assert code == 1
    assert "failed: set: /mute has not reported its parameters\n" in said
    assert "failed: get: /mute has not reported its parameters\n" in said
    assert "\nmute has not reported its parameters\n" in said
    assert "WARN console: not saved, mute has not reported its parameters\n" in said
    reason = "saved to a.yaml; not saved, mute has not reported its parameters\n"
    assert f"failed: save: {reason}" in said
    assert "left out: b.yaml:3: /mute has not reported its parameters\n" in said
    assert "failed: set: /known has no parameter x\n" in said
    assert "known:" in (here / "a.yaml").read_text()


UNUSABLE = [
    ("load bad.yaml --yes", "nothing was changed: bad.yaml:3: motor_controller max_speed: "),
    ("load nosuch.yaml", "nosuch.yaml: cannot read the parameter file: No such file"),
    ("load ''", "type the name of a file"),
    ("save there --yes", "there: not a regular file"),
    ("save there", "there already exists. Overwrite it? (add --yes to do it)"),
    ("save nosuch/x.yaml", "nosuch/x.yaml: cannot write the file: No such file"),
]


async def test_a_file_that_cannot_be_used_is_one_line(here: Path) -> None:
    (here / "there").mkdir()
    text = "motor_controller:\n  ros__parameters:\n    max_speed: 9.0\n"
    (here / "bad.yaml").write_text(text)
    code, heard = await plain("".join(f"{line}\n" for line, _ in UNUSABLE))
    assert code == 1
    for (line, said), told in zip(UNUSABLE, heard.splitlines(), strict=True):
        assert f" failed: {line.split()[0]}: {said}" in told


async def test_nodes_are_listed_halted_and_started() -> None:
    code, said = await plain("halt battery_monitor\nnodes\nstart battery_monitor\n")
    assert code == 0, said
    assert "battery_monitor stopped by you (in this process)\n" in said
    assert "motor_controller up (in this process)\n" in said
    for done in ("stop /battery_monitor", "start /battery_monitor"):
        assert f"YOU console: {done}: " in said


async def test_a_node_that_is_not_ours_or_runs_already_is_said() -> None:
    code, said = await plain("halt nosuch\nstart dashboard\nhalt dashbord\n")
    assert code == 1
    assert "failed: halt: nosuch does not run in this process\n" in said
    assert "failed: start: /dashboard is running" in said
    assert "dashbord does not run in this process (nearest: dashboard)" in said


async def test_an_alarm_is_told_with_when_it_came_and_went_and_how_it_stands() -> None:
    time = "[0-9:]{8}"
    async with operated() as person:
        await person.enter("stop", "alarm unacknowledged: STOPPED")
        person.type("shelve stopped for repair\nalarms\nrelease --yes\n")
        await person.until("release stop: ")
        station = person.station
        await until(lambda: station.view.alarms[0].is_over)
        person.type("alarms\nstatus\nshelve stopped\n")
        await person.until("no longer shelved\n")
        assert re.search(
            f"\nstopped, since {time}, shelved until {time}: for repair: STOP", person.said
        )
        over = f"\nstopped, since {time}, over at {time}, shelved until {time}: for repair: STOP"
        assert re.search(over, person.said)
        assert "\nalarm over, shelved: STOPPED: look for the cause\n" in person.said
        person.type("stop\n")
        await until(lambda: station.view.alarms and not station.view.alarms[0].is_over)
        person.type("ack\n")
        await until(lambda: station.view.alarms[0].acknowledged)
        await person.enter("alarms", ", acknowledged: STOPPED")
        assert re.search(f"\nstopped, since {time}, acknowledged: STOPPED", person.said)
        person.type("release --yes\n")
        await until(lambda: not station.view.alarms)


@asynccontextmanager
async def silent(state: str) -> AsyncIterator[Typed]:
    """A robot in that state, of which nothing has been heard for some seconds."""
    robot, standing = StubRobot(STATES[state]), StandingClock()
    async with typing(stub_station(robot, standing)) as person:
        await until(lambda: robot.listening)
        for standing.passed in (2.2, 4.4, 6.6, 8.0):  # long enough for lost contact
            robot.put(robot.snapshot)
        yield person


@pytest.mark.parametrize(
    ("words", "done"),
    [
        ("", "acknowledged: contact lost"),
        (" LOW", "acknowledged: low battery"),
        (" low battery", "acknowledged: low battery"),
        (" all", "acknowledged: contact lost, low battery"),
        (
            " nosuch",
            "failed: ack: no alarm begins with 'nosuch'; there is: contact lost, low battery",
        ),
    ],
)
async def test_alarms_are_acknowledged_first_by_name_or_all(words: str, done: str) -> None:
    async with silent("battery low and moving") as person:
        await person.until("alarm unacknowledged: CONTACT LOST")
        await person.enter(f"ack{words}", f"{done}\n")
        person.type("ack all\nack\n")
        await person.until("failed: ack: no alarm to acknowledge")


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ("low", ""),
        ("low battery is dead", "is dead"),
        ("low in the workshop", "in the workshop"),
        ("'low battery' battery", "battery"),
    ],
)
async def test_a_reason_begins_where_the_alarms_name_ends(words: str, reason: str) -> None:
    async with silent("battery low and moving") as person:
        await person.until("alarm unacknowledged: CONTACT LOST")
        await person.enter(f"shelve {words}", "low battery: shelved for 10 min\n")
        alarms = person.station.view.alarms
        assert [alarm.reason for alarm in alarms if alarm.name == "low battery"] == [reason]


async def test_a_beginning_of_several_names_is_told_with_them() -> None:
    stopped = STATES["motor stopped"]._replace(open_stop=OpenStop(NOW - 3.0))
    async with typing(stub_station(StubRobot(stopped), clock.current)) as person:
        await person.until("alarm unacknowledged: STOP SENT")
        person.type("ack stop\nack stopped\n")
        await person.until("acknowledged: stopped\n")
        said = "failed: ack: several alarms begin with 'stop': stop not confirmed, stopped\n"
        assert said in person.said


@pytest.mark.parametrize(
    ("state", "said"),
    [
        (Snapshot(file=ARCHO), "no data yet: no node publishes battery_level, motor_status"),
        (
            Snapshot(file=ARCHO, namespace="/tb2", other_namespaces=("/tb1",)),
            "no data yet: robots seen: /tb1; use --namespace /tb1",
        ),
        (Snapshot(), "no data yet"),
        (Snapshot(nodes=NORMAL.nodes), "No alarms: nothing needs attention."),
        (NORMAL, "No alarms: nothing needs attention."),
        (Snapshot(pose=Pose(received=NOW)), "No alarms: nothing needs attention."),
    ],
    ids=["nothing heard", "elsewhere", "no node", "a file without topics", "heard", "a pose"],
)
def test_no_alarms_are_a_healthy_word_only_where_something_was_heard(
    state: Snapshot, said: str
) -> None:
    station = stub_station(StubRobot(state), StandingClock())
    station.on_snapshot(state)
    outcome = asyncio.run(Alarms().run(station, {}))
    assert outcome.text == said
    assert data_of(outcome) == ([] if said.startswith("No alarms") else None)


async def test_alarms_wait_until_their_conditions_have_held_long_enough() -> None:
    async with operated(ros_args=("-p", "battery_monitor:low_battery_threshold:=95.0")) as person:
        assert await person.end("alarms\n") == 0
    assert "low battery, since " in person.said


async def test_events_are_told_as_many_as_are_asked_for() -> None:
    async with typing(stub_station(StubRobot(NORMAL), clock.current)) as person:
        person.type("events 1\nevents 0\nevents x\n")
        await person.until("failed: events: not a count of events: x")
    last = NORMAL.events[-1].text
    assert person.said.count(last) == 2, person.said  # as it happened, and as it was asked for
    assert person.said.count(NORMAL.events[-2].text) == 1
    assert "failed: events: not a count of events: 0" in person.said


async def test_the_history_has_the_last_hour_and_the_ends_of_goals() -> None:
    async with operated() as person:
        await person.enter("go 12", "ARRIVED")
        assert await person.end("history\n") == 0
    assert re.search(r"\ncharge \(%\): now \d+\.\d\d\n", person.said)
    assert re.search(r"\nspeed \(m/s\): now 0\.00\n", person.said)
    assert re.search(r"\nshelf 12 arrived, \d\d:\d\d:\d\d\n", person.said)


async def test_a_stop_that_nobody_confirms_is_given_up_with_yes() -> None:
    async with operated(Made(StandIn, "brake", "no")) as person:
        await person.enter("stop", "failed: stop: REFUSED")
        await person.enter("give_up_stop", "Send it no more? (add --yes to do it)")
        await person.enter("give_up_stop --yes", "give up STOP: given up")
        await person.enter(
            "give_up_stop --yes", "failed: give_up_stop: no STOP is waiting to be confirmed"
        )


async def test_a_goal_of_the_file_is_sent_by_action_and_label_or_field() -> None:
    async with operated(ros_args=LONG) as person:
        person.type("send_goal move_to_shelf 12\nsend_goal /move_to_shelf Shelf=7\n")
        await person.until("queue: 7\n")
        person.type("send_goal move_to_shelf shelf_number=3\ncancel --all\n")
        await person.until("(add --yes to do it)")
        assert await person.end("cancel --yes --all\n") == 1
    assert "go to shelf 12: accepted" in person.said
    assert "cancel every goal: cancelling 1 goal" in person.said
    assert "not driven: 7, 3 (cancelled)" in person.said


async def test_a_goal_behind_a_queue_that_is_held_is_said_to_wait_there() -> None:
    async with operated(ros_args=LONG) as person:
        await person.enter("go 12 7", "queue: 7\n")
        await person.enter("cancel", "queue held: 7 (cancelled)")
        person.type("go 3\ngo 5\n")
        await person.until("queue: held: 7, 5 (cancelled)\n")
        assert await person.end("cancel\n") == 1


async def test_any_action_and_service_on_the_graph_take_fields_and_yaml() -> None:
    code, said = await plain(
        "send_goal fibonacci order=3\n"
        "call plan '{waypoints: [{x: 1.0}, {x: 2.0}], fast: true}'\n"
        "call /plan weights=[1.5] fast=yes\n",
        Counting,
    )
    assert code == 0, said
    assert "YOU console: call plan: legs 2, route by the wall" in said
    assert "YOU console: call plan: legs 0, route by the wall" in said
    assert "goal SUCCEEDED, fibonacci 3, sequence [0, 1, 1, 2]" in said


UNFITTING = [
    ("call plan nosuch=1", "expected start."),
    ("call plan fast", "expected start."),
    ("call plan fast=perhaps", "fast: not true or false: perhaps"),
    ("call plan {fast: 1}", "expected "),
    ("call plan '{fast: 1}'", "fast: 1 is not"),
    ("call plan '{fast: '", "not YAML: "),
    ("call plann", "no service /plann is on the graph (nearest: /plan)"),
    ("send_goal fibonacci order=x", "order: not a whole number: x"),
    ("send_goal fibonaci order=1", "no action /fibonaci is on the graph (nearest: /fibonacci)"),
]


async def test_what_does_not_fit_an_action_or_service_is_said() -> None:
    code, heard = await plain("".join(f"{line}\n" for line, _ in UNFITTING), Counting)
    assert code == 1
    for (line, said), told in zip(UNFITTING, heard.splitlines(), strict=True):
        assert f"failed: {line.split()[0]}: " in told
        assert said in told


async def test_names_are_typed_with_or_without_the_namespace() -> None:
    code, said = await plain(
        f"get {SPEED}\nget wh/{SPEED}\nget /wh/{SPEED}\ncall reset_encoder\ncall wh/reset_encoder\n"
        "call /wh/reset_encoder\nhalt dashboard\nstart wh/dashboard\nget nosuch x\n",
        namespace="/wh",
    )
    assert said.count(f"wh/{SPEED} is 0.8, double") == 3, said
    assert said.count("YOU console: reset encoder: Encoder reset to zero") == 3
    assert "YOU console: start /wh/dashboard: " in said
    assert [line for line in said.splitlines() if "failed" in line] == [
        line for line in said.splitlines() if line.endswith("no node /wh/nosuch is on the graph")
    ]
    assert code == 1


class OfTwoNamespaces(Node):
    """Serves a service of one name in its namespace and at the root, and an action at the root."""

    def __init__(self, **given: Any) -> None:
        super().__init__("two", **given)
        self.create_service(Trigger, "e_stop", partial(self._tell, "inside"))
        self.create_service(Trigger, "/e_stop", partial(self._tell, "outside"))
        ActionServer(self, Fibonacci, "spin", partial(self._execute, 1))
        ActionServer(self, Fibonacci, "/spin", partial(self._execute, 2))

    @staticmethod
    def _tell(word: str, request: Any, response: Any) -> Any:
        response.success, response.message = True, word
        return response

    @staticmethod
    def _execute(number: int, handle: Any) -> Any:
        handle.succeed()
        return Fibonacci.Result(sequence=[number])


async def test_a_name_that_begins_with_a_slash_is_not_of_the_namespace() -> None:
    code, said = await plain(
        "call e_stop\ncall /e_stop\ncall /tb1/e_stop\nsend_goal /spin order=1\n",
        OfTwoNamespaces,
        namespace="/tb1",
    )
    assert code == 0, said
    told = [line.partition("console: ")[2] for line in said.splitlines() if ": call " in line]
    assert told == [
        "call tb1/e_stop: success true, message inside",
        "call e_stop: success true, message outside",
        "call tb1/e_stop: success true, message inside",
    ]
    assert "goal SUCCEEDED, spin 1, sequence [2]" in said
    code, said = await plain("call /plan\n", Counting, namespace="/tb1")
    assert code == 1
    assert "failed: call: no service /plan is on the graph (nearest: /tb1/plan)" in said


async def test_help_and_quit_take_no_values() -> None:
    code, said = await plain("help go\nquit now\nstatus\n")
    assert code == 1
    assert "failed: help: takes no values" in said
    assert "failed: quit: takes no values" in said
    assert "\nbattery " in said


async def test_what_a_robot_does_not_have_is_said(here: Path) -> None:
    (here / "bare.yaml").write_text("version: 1\nname: Bare\nstop: none\n")
    lines = {
        "events": "no events yet\n",
        "history": "nothing yet\n",
        "status": "motion the robot file names no motion\ngoal the robot file names no goal\n",
        "release": "failed: release: Bare has no service to release a stop\n",
        "go 1": "failed: no command 'go' (help lists them)\n",
        "undo": "failed: undo: nothing to undo\n",
        "save x": "failed: save: no node has reported its parameters yet\n",
    }
    code, said = await plain("\n".join(lines), robot=here / "bare.yaml", only=True)
    assert code == 1
    for told in lines.values():
        assert told in said, said
    code, said = await plain("stop\n", robot=here / "bare.yaml", only=True)
    assert code == 1
    why = "Bare has no STOP: use the hardware stop (this is not a STOP: no action is offered"
    assert f"failed: stop: {why} by any node)\n" in said


async def test_a_nodes_log_level_is_shown_set_and_unset() -> None:
    code, said = await plain(
        "log_level motor_controller\nlog_level /motor_controller WARN\n"
        "log_level motor_controller\nlog_level motor_controller unset\n"
        "log_level countign\nlog_level counting loud\nlog_level counting debug\n",
        *_robots_nodes(False).values(),
        Counting,
    )
    assert code == 1
    lines = said.splitlines()
    assert lines[0] == "motor_controller logs INFO and above, the level of its process"
    assert said.count("log level of motor_controller WARN: WARN and above, was INFO") == 1
    assert "motor_controller logs WARN and above" in lines
    assert "UNSET: INFO and above, the level of its process, was WARN and above" in said
    assert "failed: log_level: no node /countign is on the graph (nearest: counting)" in said
    assert "loud is not a log level: one of unset, debug, info, warn, error, fatal" in said
    assert "does not offer the level of its log (in rclpy: enable_logger_service=True)" in said


async def test_a_grave_alarm_is_shelved_with_a_reason_only() -> None:
    async with silent("motor stop not confirmed") as person:
        await person.until("alarm unacknowledged: CONTACT LOST")
        person.type("shelve stop\nshelve stop the hardware stop is pressed\nalarms\n")
        await person.until(": the hardware stop is pressed: ")
    assert "failed: shelve: type a reason: it goes into the journal" in person.said
    assert "stop not confirmed: shelved for 10 min\n" in person.said
