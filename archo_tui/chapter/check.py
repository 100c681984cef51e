"""What the textbook's chapter asks of its nodes, asked; the outcome is in TAP.

https://testanything.org: a line a check, `ok` or `not ok`, with hints below the latter. A check of
something that no node of the files offers is skipped, and says what they offer instead.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from archo_tui.chapter.asker import Asker
from archo_tui.chapter.moves import moves
from archo_tui.chapter.parameters import parameters
from archo_tui.chapter.services import services
from archo_tui.chapter.tap import Result
from archo_tui.chapter.topics import topics
from archo_tui.robot.text import safe
from archo_tui.session import Session

_PARTS = topics, parameters, moves, services  # what stops the robot comes last
_NOTHING = "# nothing was checked: these nodes offer nothing that the chapter asks for"


def check(
    session: Session, radius: float, printed: Sequence[str], say: Callable[[str], None]
) -> int:
    """Run every check, a line at a time; returns the exit code: 0 when one passed and none failed.

    `radius` is the wheel_radius (m) of a parameter file that all nodes were given, `printed` what
    they print.
    """
    asker = Asker(session, radius, printed)
    count = failed = skipped = 0

    def show(result: Result) -> None:
        nonlocal count, failed, skipped
        count, failed = count + 1, failed + bool(result.hint)
        skipped += bool(result.skipped)
        for line in result.lines(count):
            say(line)

    say("TAP version 13")
    for line in asker.not_run():
        say(f"# {safe(line)}")
    try:
        for part in _PARTS:
            for result in part(asker):
                show(result)
        nothing = skipped == count
        asker.wait_for_crashes()
        show(Result("no node crashes", "\n".join(asker.all_crashes())))
    except KeyboardInterrupt:
        say("Bail out! interrupted")
        raise
    finally:
        asker.close()
    if nothing:
        say(_NOTHING)
    say(f"1..{count}")
    return 1 if failed or nothing else 0
