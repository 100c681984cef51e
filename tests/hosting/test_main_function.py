"""The nodes that `main()` makes are hosted as it makes them; what else it does is said."""

from __future__ import annotations

from pathlib import Path

import pytest

from archo_tui.errors import ArchoError
from archo_tui.hosting.node_files import NodeFile
from archo_tui.session import Session
from archo_tui.session_options import Options
from tests.support import chosen, clock
from tests.support.waiting import wait_until

HEAD = """
import sys
import rclpy
from rclpy.node import Node
from std_msgs.msg import Float32
NAME = "talker"


class Talker(Node):
    def __init__(self, name="nobody", count=1):
        super().__init__(name)
        self.count = count

    def send(self, number):
        pass


class Unused(Node):
    def __init__(self, robot):
        super().__init__("unused")


"""
FIRST = HEAD.count("\n") + 2  # the line below `def main():`


def loaded(here: Path, body: str, rest: str = "") -> NodeFile:
    path = here / "talker.py"
    indented = "".join(f"    {line}\n" for line in body.splitlines())
    path.write_text(f"{HEAD}def main(args=None):\n{indented}{rest}")
    return NodeFile(str(path))


def names(here: Path, body: str, rest: str = "") -> list[str]:
    """The nodes that are hosted, with the count that each was given."""
    file = loaded(here, body, rest)
    options = Options(
        engine=chosen.ENGINE, domain_id=chosen.next_domain(), node_files=(str(file),), only=True
    )
    with Session(options, clock.current) as session:
        nodes = [(n.name, getattr(n.node, "count", 0)) for n in session.host.nodes]
        return [f"{name} {count}" for name, count in nodes]


@pytest.mark.parametrize(
    ("body", "found"),
    [
        ("Talker()", "/nobody 1"),
        ("Talker('a', count=3)", "/a 3"),
        ("Talker(NAME)", "/talker 1"),
        ("name = 'b'\nTalker(name)", "/b 1"),
        ("rclpy.spin(Talker('a'))", "/a 1"),
        ("b, a = Talker('b'), Talker('a', 2)", "/b 1, /a 2"),
        ("if args:\n    Talker('a')\nelse:\n    Talker('a')", "/a 1"),
        ("with Talker('a') as talker:\n    rclpy.spin(talker)", "/a 1"),
        ("try:\n    run('c')\nfinally:\n    rclpy.shutdown()", "/c 1"),
        ("node = Node('plain')\nrclpy.spin(node)", "/plain 0"),
        ("node = rclpy.create_node('made', namespace='/ns')", "/ns/made 0"),
        ("rclpy.node.Node('plain', context=args)", "/plain 0"),
    ],
)
def test_the_nodes_that_main_makes_are_hosted_as_it_makes_them(
    body: str, found: str, here: Path
) -> None:
    rest = "\n\ndef run(name):\n    rclpy.spin(Talker(name))\n"
    assert ", ".join(names(here, body, rest)) == found


def test_what_stands_below_the_if_counts_as_main(here: Path) -> None:
    rest = "\n\nif __name__ == '__main__':\n    Talker('below')\n"
    assert names(here, "pass", rest) == ["/below 1"]


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("node = Talker()\nnode.send(3)", "1: main() calls node.send(3), which is not run here"),
        (
            "node = Talker()\nfuture = node.send(3)\n"
            "rclpy.spin_until_future_complete(node, future)\nnode.send(4)\nnode.destroy_node()",
            "1: main() calls node.send(3), which is not run here, nor is line +3",
        ),
        (
            "node = Talker()\nwhile rclpy.ok():\n    rclpy.spin_once(node)\n    node.send(1)",
            "3: main() calls node.send(1), which is not run here",
        ),
        ("node = Talker()\ndrive(node)", "5: drive() calls it.send(1), which is not run here"),
        ("node = Talker()\nsys.exit(node.send)", "1: main() calls sys.exit(node.send), which is"),
        ("node = Talker()\nnode.get_logger().info('up')\nrclpy.spin(node)\nnode.send(1)", ""),
        ("try:\n    rclpy.spin(Talker())\nexcept Exception:\n    print(1)", ""),
        ("node = Talker()\ntry:\n    rclpy.spin(node)\nfinally:\n    node.send(0)", ""),
    ],
)
def test_another_call_in_main_is_said_by_its_line(body: str, said: str, here: Path) -> None:
    file = loaded(here, body, "\n\ndef drive(it):\n    it.send(1)\n")
    file.load()
    if not said:
        assert file.not_run == ""
        return
    line, _, text = said.partition(":")
    for offset in range(9):
        text = text.replace(f"+{offset}", str(FIRST + offset))
    assert file.not_run.startswith(f"{file}:{FIRST + int(line)}:{text}"), file.not_run


def test_what_is_not_run_is_an_event_at_the_start(here: Path) -> None:
    file = loaded(here, "node = Talker()\nnode.send(3)")
    options = Options(
        engine=chosen.ENGINE, domain_id=chosen.next_domain(), node_files=(str(file),), only=True
    )
    with Session(options, clock.current) as session:
        said = f"{file}:{FIRST + 1}: main() calls node.send(3), which is not run here"
        wait_until(
            lambda: (
                [(e.level, e.source) for e in session.robot.snapshot.events if e.text == said]
                == [("WARN", "talker.py")]
            )
        )


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("Talker(sys.argv[1])", "0: Talker(sys.argv[1]) takes what main() computes"),
        ("for n in range(3):\n    Talker(f't{n}')", "1: Talker(f't{n}') takes what main()"),
        ("Unused()", "0: TypeError: Unused.__init__() missing 1 required"),
    ],
)
def test_a_node_that_only_main_could_make_is_said_by_its_line(
    body: str, said: str, here: Path
) -> None:
    line, _, text = said.partition(":")
    with pytest.raises(ArchoError) as caught:
        names(here, body)
    assert str(caught.value).startswith(f"talker.py:{FIRST + int(line)}:{text}"), caught.value
