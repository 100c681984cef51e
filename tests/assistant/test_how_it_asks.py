"""Goals: asked for and never promised, waited for, cancelled; and STOP, ahead of everything."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

from tests.assistant.support import GOALS, Request, assistant, fake_console
from tests.support.shells import until

pytestmark = pytest.mark.real_time

ASKED: dict[str, Any] = {
    "code": "asked",
    "text": "request 3 waits for a person",
    "data": {"request": 3, "expires_in": 60.0},
}


async def test_go_answers_at_once_with_a_number_and_no_word_of_success() -> None:
    async with fake_console() as console, assistant("--allow", "goals") as model:
        console.answer("ask", **ASKED)
        said = await model.call("go", kind="go", values={"shelf_number": 12})
        assert (said.failed, said.data["code"]) == (False, "asked")
        assert said.data["summary"] == (
            "Request 3 waits for a person at the console. Nothing moves yet. "
            "Call `wait` with request 3."
        )
        assert said.robot["data"] == {"request": 3, "expires_in": 60.0}
        asked = {"kind": "go", "values": {"shelf_number": 12}}
        assert console.asked == [{"id": 1, "assistant": True, "ask": asked}]


NOT_ASKED = [
    ("refused", "three requests wait already"),
    ("watching", "this console only watches"),
    ("lost", "the screen was restarted"),
]


async def test_what_is_not_asked_says_why_and_is_a_failure() -> None:
    async with fake_console() as console, assistant("--allow", "goals") as model:
        for code, text in NOT_ASKED:
            console.answer("ask", code, text)
            said = await model.call("go", kind="go", values={})
            assert (said.failed, said.data["code"]) == (True, code)
            assert said.data["summary"].startswith("Nothing was asked, and nothing moves")
            assert said.robot["said"] == [text]
        for code in ("asked", "done", "accepted", "arrived"):  # without the number of a request
            console.answer("ask", code, "as you wish")
            said = await model.call("go", kind="go", values={})
            assert (said.failed, said.data["code"]) == (True, "not_confirmed")
            assert said.data["summary"].startswith("This answer is not understood")
        console.answer("ask", "misuse", "shelf_number: 1 .. 40")
        said = await model.call("go", kind="go", values={"shelf_number": 99})
        assert (said.failed, said.data["code"]) == (True, "misuse")
        assert said.robot == {"said": ["shelf_number: 1 .. 40"], "goals": GOALS}


ENDS = [
    ("arrived", "The goal arrived: the robot's own result says so.", False),
    ("denied", "A person said no, and this request moved nothing", True),
    ("expired", "Nobody answered in time", True),
    ("void", "The request became void", True),
    ("aborted", "The goal ended without arriving", True),
    ("cancelled", "The goal was cancelled", True),
    ("timeout", "It is not known to have arrived", True),
    ("misuse", "Nothing is known of such a request", True),
    ("done", "It is not known to have arrived", True),  # only the action's result is a success
]


async def test_wait_tells_the_end_and_success_only_of_an_arrival() -> None:
    async with fake_console() as console, assistant("--allow", "goals") as model:
        for code, words, failed in ENDS:
            console.answer("wait", code, "as it ended", data={"kind": "go"})
            said = await model.call("wait", request=3)
            assert (said.failed, said.data["code"]) == (failed, code)
            assert said.data["summary"].startswith(words)
            assert said.robot == {"said": ["as it ended"], "data": {"kind": "go"}}
            assert console.words()[-1] == ["wait", "request", "3"]
        assert len(console.asked) == len(ENDS)
        console.answer("wait", "ran_out", "waits for a person, 55 s are left")
        said = await model.call("wait", request=3, seconds=0)
        assert (said.failed, said.data["code"]) == (False, "ran_out")
        assert said.robot["said"] == ["waits for a person, 55 s are left"]
        assert 0 < console.asked[-1]["timeout"] < 1


async def test_another_call_does_not_wait_for_a_wait() -> None:
    async with fake_console() as console, assistant("--allow", "goals") as model:
        ended = asyncio.Event()

        async def a_while(request: Request) -> Request:
            try:
                await asyncio.wait_for(ended.wait(), request["timeout"])
            except asyncio.TimeoutError:
                return {"code": "ran_out", "text": "the goal runs"}
            return {"code": "cancelled", "text": "Cancelled mid-route"}

        console.answers["wait"] = a_while
        console.answer("cancel", "accepted", "accepted")
        waits = asyncio.ensure_future(model.call("wait", request=3))
        await until(lambda: ["wait", "request", "3"] in console.words())
        said = await model.call("cancel")
        assert (said.failed, said.data["code"]) == (False, "accepted")
        assert said.data["summary"].startswith("The robot accepts the cancel")
        assert not waits.done()
        ended.set()
        assert (await waits).data["code"] == "cancelled"
        assert console.connections == 1
        assert all(request["timeout"] <= 1.0 for request in console.asked if "timeout" in request)


async def test_stop_waits_for_nothing_that_is_in_flight() -> None:
    async with fake_console() as console, assistant("--allow", "goals") as model:
        console.answer("stop", "done", "confirmed")
        console.answer("status", "done", data={})
        waits = asyncio.ensure_future(model.call("wait", request=3))  # never answered
        looks = asyncio.ensure_future(model.call("status"))  # behind it
        await until(lambda: console.asked)
        said = await model.call("stop")
        assert said.data["summary"].startswith("STOP is confirmed by the robot. Only a person")
        assert not waits.done()
        assert not looks.done()
        assert console.words() == [["wait", "request", "3"], ["stop"]]
        assert console.connections == 2
        console.drop()
        assert (await waits).failed
        assert "news" in (await looks).data  # on another connection: its turn had not come


async def test_what_is_not_done_says_why_and_a_stop_names_the_hardware_stop() -> None:
    async with fake_console() as console, assistant("--allow", "goals") as model:
        for code in ("not_offered", "not_confirmed", "timeout", "refused", "lost"):
            console.answer("stop", code, "the robot does not answer")
            said = await model.call("stop")
            assert (said.failed, said.data["code"]) == (True, code)
            assert "hardware stop" in said.data["summary"]
        console.answer("cancel", "done", "withdrawn: 3")
        said = await model.call("cancel")
        assert said.data["summary"].startswith("Withdrawn")
        console.answer("cancel", "refused", "no goal of the assistant runs")
        said = await model.call("cancel")
        assert said.failed
        assert said.robot["said"] == ["no goal of the assistant runs"]
