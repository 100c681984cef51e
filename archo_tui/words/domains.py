"""The text of what was found in other ROS 2 domains. Pure functions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

_NAMED = 4  # Nodes of a domain that are named.


def domains_text(found: Mapping[int, Sequence[str]], first: int, last: int) -> str:
    """Return a line for each domain with nodes, and how to operate the robot there."""
    if not found:
        return (
            f"no node in the domains {first} to {last}, as far as this computer's discovery "
            "reaches (ROS_AUTOMATIC_DISCOVERY_RANGE)"
        )
    return "\n".join(
        f"domain {domain}: {_nodes(nodes)}: start with ROS_DOMAIN_ID={domain}"
        for domain, nodes in sorted(found.items())
    )


def _nodes(nodes: Sequence[str]) -> str:
    named = ", ".join(nodes[:_NAMED])
    return f"{named} and {len(nodes) - _NAMED} more" if len(nodes) > _NAMED else named
