"""The ends of one topic: who publishes and who subscribes, with which type and QoS."""

from __future__ import annotations

from typing import NamedTuple


class TopicEnd(NamedTuple):
    """A publisher or a subscription.

    Attributes:
        node: The full name of its node.
        type: The type of its messages.
        qos: Its reliability and durability in DDS's words: `RELIABLE, VOLATILE`.
    """

    node: str
    type: str
    qos: str


class TopicInfo(NamedTuple):
    """All ends of a topic.

    Attributes:
        publishers: Its publishers, by node.
        subscriptions: Its subscriptions, by node; those of hidden nodes are left out.
        mismatches: A text for each subscription that receives nothing, with the remedy.
    """

    publishers: tuple[TopicEnd, ...] = ()
    subscriptions: tuple[TopicEnd, ...] = ()
    mismatches: tuple[str, ...] = ()
