"""The ends of one topic: who publishes and who subscribes, with which type and QoS."""

from __future__ import annotations

from typing import NamedTuple


class TopicEnd(NamedTuple):
    """A publisher or a subscription."""

    node: str
    type: str  # The type of its messages.
    qos: str  # Its reliability and durability in DDS's words: `RELIABLE, VOLATILE`.


class TopicInfo(NamedTuple):
    """The publishers and subscriptions of a topic."""

    publishers: tuple[TopicEnd, ...] = ()  # The publishers, sorted by node.
    subscriptions: tuple[TopicEnd, ...] = ()  # The subscriptions, sorted by node.
    # A text with the remedy for each subscribing node that receives nothing, or may misread what it
    # receives.
    mismatches: tuple[str, ...] = ()
