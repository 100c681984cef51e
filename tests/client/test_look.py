"""What `look` says of the domains in which there are nodes."""

from __future__ import annotations

from archo_tui.cli.graph import domains_text


def test_each_domain_with_nodes_is_a_line_with_how_to_start_there() -> None:
    found = {7: ["/a", "/b", "/c", "/d", "/e", "/f"], 0: ["/base"]}
    assert domains_text(found).splitlines() == [
        "domain 0: /base: start with ROS_DOMAIN_ID=0",
        "domain 7: /a, /b, /c, /d and 2 more: start with ROS_DOMAIN_ID=7",
    ]


def test_nothing_found_is_said_with_what_limits_the_look() -> None:
    said = domains_text({})
    assert said.startswith("no node in the domains 0 to 20")
    assert "ROS_AUTOMATIC_DISCOVERY_RANGE" in said
