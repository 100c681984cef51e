"""Panel 8: topics, services and actions, who has them, and how often they come."""

from __future__ import annotations

import pytest

from tests.support import clock
from tests.support.console import FAST, Console, console
from tests.support.front import front
from tests.support.states import NORMAL
from tests.support.stub import StandingClock


async def rows(op: Console, *keys: str) -> list[list[str]]:
    """The lines of the graph on the full screen, in words."""
    await op.press("8", *keys)
    await op.until("8 Graph")
    return [
        line[1:-1].split() for line in op.text.splitlines() if "/msg/" in line or "/srv/" in line
    ]


async def test_it_shows_types_and_who_publishes_or_serves_them() -> None:
    from std_msgs.msg import Float32

    async with console(*FAST) as op:
        found = await rows(op)
        level = ["topic", "/battery_level", "archo_interfaces/msg/BatteryStatus", "battery_monitor"]
        assert any(row[:4] == level for row in found)
        assert ["service", "/set_charging", "std_srvs/srv/SetBool", "battery_monitor"] in found
        action = "/move_to_shelf archo_interfaces/action/MoveToShelf motor_controller"
        await op.until(lambda: action in op.words)
        assert "no publisher" in op.line("/battery_drain")
        for own in ("/rosout", "/parameter_events", "get_parameters", "_archo_console"):
            assert own not in op.text

        await op.press("escape")
        await op.press("8")
        await op.until(lambda: "no publisher" in op.line("/battery_drain"))
        await op.at(clock.seconds() + 3)  # nothing else comes any more
        node = op.session.host.nodes[2].node
        node.create_publisher(Float32, "battery_drain", 10)
        await op.until(lambda: "motor_controller" in op.line("/battery_drain"))


async def test_the_rate_of_what_the_console_hears_is_there_and_its_silence() -> None:
    async with console() as op:
        await op.press("8")
        await op.until(lambda: op.line("/battery_level").rstrip("┃ ").endswith("1.0 Hz"))
        await op.until(lambda: op.line("/motor_status").rstrip("┃ ").endswith("5.0 Hz"))
        await op.press("escape", "5", "home", "s")
        await op.until("○ battery_monitor")
        await op.press("8")
        await op.until(lambda: "no publisher" in op.line("/battery_level"))
        await op.until(lambda: "silent" in op.line("/battery_level"))
        assert "/set_charging" not in op.text
        await op.press("escape", "5", "home", "s", "8")
        await op.until(lambda: "battery_monitor" in op.line("/set_charging"))
        await op.until(lambda: "Hz" in op.line("/battery_level"))


async def test_enter_shows_all_that_is_known_of_one() -> None:
    async with front() as it:
        text = await it.write("8", "down", "enter")
        assert "archo_interfaces/msg/BatteryStatus" in text
        assert "from /battery_monitor" in text
        assert "served by     /motor_controller" in await it.write("escape", "end", "enter")


async def test_where_it_has_no_room_8_opens_it_and_escape_goes_back() -> None:
    async with front(size=(80, 24)) as it:
        for width, height in ((80, 24), (120, 36), (200, 24)):
            await it.resize(width, height)
            await it.press("5")
            assert not it.main.graph.display
            await it.press("8")
            assert it.main.graph.size.width > width - 6
            assert not it.main.nodes.region
            await it.press("escape")
            assert not it.main.graph.display
            assert it.focused_panel == 5
        # its focus and full screen outlast every size
        await it.resize(160, 48)
        await it.press("8")
        await it.resize(149, 43)  # there is no room any more
        assert it.focused_panel == 4
        await it.press("8")
        await it.resize(150, 48)
        assert it.main.is_full
        assert it.focused_panel == 8
        await it.press("escape")
        assert it.focused_panel == 8
        assert it.main.nodes.region
        for width, height in ((1, 1), (160, 30)):
            await it.resize(width, height)
        assert it.main.graph.region.height >= 5


async def test_panels_cost_nothing_while_nothing_in_them_changes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    hidden = NORMAL.parameters[0]._replace(name="use_sim_time", value=False, initial=False)
    before = NORMAL._replace(parameters=(*NORMAL.parameters, hidden))
    clock, drawn = StandingClock(), list[str]()
    async with front(before, clock, size=(160, 48)) as it:
        await it.press("8")
        for panel in (it.main.graph.focus_target, it.main.parameters):
            name = str(panel.id)
            note = lambda *_, name=name, **__: drawn.append(name)  # noqa: E731
            monkeypatch.setattr(panel, "refresh", note)
        for second in range(3):
            clock.passed += 1.0
            rates = {
                name: rate._replace(heard=rate.heard + second)
                for name, rate in NORMAL.message_rates.items()
            }
            it.robot.put(before._replace(message_rates=rates))
            await it.tick()
        assert drawn == []
        it.robot.put(NORMAL._replace(resources=NORMAL.resources[1:]))
        it.app.tick()
        assert len({*drawn}) == 2


async def test_the_lists_get_what_they_need_and_the_events_the_rest() -> None:
    async with front(size=(200, 60)) as it:
        main = it.main
        for width, height in ((150, 30), (200, 60)):
            await it.resize(width, height)
            assert main.nodes.region.height == 7  # three nodes, at least five rows
            upper = main.goal.region.height + main.parameters.region.height
            assert upper == (17 if height <= 40 else main.goal.region.height + 7)
            assert main.graph.region.bottom == main.history.region.bottom or height <= 40
            if height > 40:  # The history has a row of its own, and events at most a quarter.
                assert main.history.region.height >= 17
                assert 8 <= main.events.region.height <= height // 4
                assert main.events.region.width == width
            assert main.events.region.width >= 60
            assert main.events.region.bottom == height - 1
        for size, rows in (((80, 24), 5), ((80, 30), 9), ((120, 36), 15)):
            await it.resize(*size)
            assert main.events.region.height == rows  # three and more, with the border
            assert main.parameters.region.height >= 5  # both that are shown
        await it.resize(300, 80)
        nodes = tuple(NORMAL.nodes[0]._replace(name=f"/node_{n}") for n in range(40))
        many = tuple(NORMAL.parameters[0]._replace(name=f"gain_{n}") for n in range(20))
        await it.put(NORMAL._replace(nodes=nodes, parameters=many))
        assert main.nodes.region.height == 14
        height = main.parameters.region.height
        await it.write("4", "slash", *"gain_7")  # moves nothing
        assert len(main.parameters.rows.items) == 1
        assert main.parameters.region.height == height
