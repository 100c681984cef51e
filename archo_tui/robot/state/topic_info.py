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
    """The publishers and subscriptions of a topic.

    Attributes:
        publishers: The publishers, sorted by node.
        subscriptions: The subscriptions, sorted by node; those of hidden nodes are left out.
        mismatches: A text with the remedy for each subscribing node that receives nothing, or may
            misread what it receives.
    """

    publishers: tuple[TopicEnd, ...] = ()
    subscriptions: tuple[TopicEnd, ...] = ()
    mismatches: tuple[str, ...] = ()
