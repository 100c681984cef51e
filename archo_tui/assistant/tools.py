"""Which tools an assistant has. There is none that releases, sets, allows or hosts anything."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from archo_tui.assistant.answer import Answer, failure
from archo_tui.assistant.arguments import Misuse, check, shown
from archo_tui.assistant.link import Link
from archo_tui.assistant.looking import Events, History, Parameters, Status
from archo_tui.assistant.moving import Cancel, Go, Wait
from archo_tui.assistant.stopping import Stop
from archo_tui.assistant.tool import Tool
from archo_tui.plain.lines import is_stop_text
from archo_tui.remote.client import Unreached
from archo_tui.robot.text import harmless


def tools(*, goals: bool) -> dict[str, Tool]:
    """All of them by name; with `goals` those that ask for motion too."""
    made: list[Tool] = [Status(), Events(), History(), Parameters(), Stop()]
    if goals:
        made += [Go(), Wait(), Cancel()]
    return {tool.name: tool for tool in made}


async def call(
    known: Mapping[str, Tool], link: Link, name: str, given: dict[str, Any]
) -> tuple[dict[str, Any], bool]:
    """The answer as JSON has it, and whether it failed; never raises for what a model does."""
    answer = await _answer(known, link, name, given)
    return answer.as_data(link.take_news()), answer.failed


async def _answer(
    known: Mapping[str, Tool], link: Link, name: str, given: dict[str, Any]
) -> Answer:
    tool = known.get("stop" if is_stop_text(name) else name)
    if tool is None:
        others = f"the tools are {', '.join(known)}"
        return failure("misuse", f"no tool {shown(name)}: {others}; the rest a person does.")
    try:
        check(tool.schema, given)
        return await tool.call(link, given)
    except Misuse as error:
        return failure("misuse", f"{error}. Nothing was sent.")
    except Unreached as error:
        head, *rest = str(error).splitlines()
        return failure("unreached", harmless(head), {"said": rest} if rest else None)
