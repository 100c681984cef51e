"""The last minute in memory: bounded in time and bytes, with what stands from before."""

from __future__ import annotations

from rclpy.serialization import deserialize_message
from std_msgs.msg import String

from archo_tui.recordings.bag import LazyMessage, ReceivedMessage
from archo_tui.recordings.recorder import MAX_BYTES, Ring
from tests.support.bags import received


def heard(seconds: float, topic: str = "/battery_level", text: str = "") -> ReceivedMessage:
    return received(int(seconds * 1e9), topic, String(data=text))


def text_of(one: ReceivedMessage) -> str:
    assert isinstance(one.content, bytes)
    said: str = deserialize_message(one.content, String).data
    return said


def texts(ring: Ring) -> list[str]:
    return [text_of(one) for one in kept(ring)]


def kept(ring: Ring) -> list[ReceivedMessage]:
    latched, number = ring.begin()
    ring.hold(float("inf"))
    return [*latched, *ring.since(number)[0]]


def test_what_is_older_than_its_span_goes() -> None:
    ring = Ring(span=60.0)
    for second in range(100):
        ring.add(heard(second, "/rosout", str(second)))
    assert texts(ring) == [str(second) for second in range(39, 100)]


def test_more_bytes_than_it_may_take_push_the_oldest_out() -> None:
    ring = Ring(max_bytes=10_000)
    for number in range(100):
        ring.add(heard(number / 1000, "/rosout", str(number).zfill(1000)))
        assert ring.bytes <= 10_000
    assert texts(ring) == [str(number).zfill(1000) for number in range(92, 100)]


def test_the_last_of_a_topic_stands_at_the_begin_though_it_is_older() -> None:
    ring = Ring(span=60.0)
    for second, topic in ((0, "/battery_level"), (1, "/battery_level"), (2, "/rosout")):
        ring.add(heard(second, topic, str(second)))
    ring.add(heard(100, "/rosout", "now"))
    assert texts(ring) == ["1", "now"]
    assert {one.time for one in kept(ring)} == {100 * 10**9}


def test_what_a_recording_has_not_taken_is_kept() -> None:
    ring = Ring(span=60.0)
    ring.add(heard(1, "/rosout", "before"))
    _, first = ring.begin()
    ring.add(heard(100, "/rosout", "after"))
    taken, following = ring.since(first)
    assert [text_of(one) for one in taken] == ["before", "after"]
    ring.hold(following)
    ring.add(heard(101, "/rosout", "more"))
    assert [text_of(one) for one in ring.since(following)[0]] == ["more"]
    ring.add(heard(200, "/rosout", "x" * MAX_BYTES))
    assert ring.first > following  # Of too many the oldest go all the same.


def test_a_message_weighs_about_what_its_bytes_do() -> None:
    assert 1000 < heard(1, text="x" * 1000).bytes < 1500
    later = LazyMessage(lambda first, since: String(), 1230)
    assert 1230 < ReceivedMessage(1, "/later", String, later).bytes < 1700


def test_one_message_that_is_too_large_alone_leaves_what_stands_with_its_time() -> None:
    ring = Ring(max_bytes=10_000)
    ring.add(heard(50, "/battery_level", "stands"))
    ring.add(heard(51, "/rosout", "x" * 20_000))
    (one,) = kept(ring)
    assert (text_of(one), one.time, ring.bytes) == ("stands", 50 * 10**9, 0)
    ring = Ring()  # What is too large does not stand on.
    ring.add(heard(1, "/map", "x" * 2_000_000))
    ring.add(heard(100, "/rosout", "now"))
    assert texts(ring) == ["now"]
