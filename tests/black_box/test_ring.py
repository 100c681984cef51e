"""The last minute in memory: bounded in time and bytes, with what stands from before."""

from __future__ import annotations

from std_msgs.msg import String

from archo_tui.recording.ring import LazyMessage, ReceivedMessage, Ring, weight


def heard(seconds: float, topic: str = "/battery_level", text: str = "") -> ReceivedMessage:
    return ReceivedMessage(int(seconds * 1e9), topic, String(data=text))


def nobody(_: ReceivedMessage, __: int) -> None:
    """Listens to what follows, in vain."""


def texts(ring: Ring) -> list[str]:
    kept = ring.subscribe(nobody)
    ring.unsubscribe(nobody)
    return [one.message.data for one in kept]


def test_what_is_older_than_its_span_goes() -> None:
    ring = Ring(span=60.0)
    for second in range(100):
        ring.add(heard(second, "/rosout", str(second)), second)
    assert texts(ring) == [str(second) for second in range(39, 100)]


def test_more_bytes_than_it_may_take_push_the_oldest_out() -> None:
    ring = Ring(max_bytes=10_000)
    for number in range(100):
        ring.add(heard(number / 1000, "/rosout", str(number).zfill(1000)), number / 1000)
        assert ring.bytes <= 10_000
    assert texts(ring) == [str(number).zfill(1000) for number in range(92, 100)]


def test_one_message_that_is_too_large_alone_leaves_it_empty() -> None:
    ring = Ring(max_bytes=10_000)
    ring.add(heard(1, "/rosout", "x" * 20_000), 1)
    assert texts(ring) == []
    assert ring.bytes == 0


def test_the_last_of_a_topic_stands_at_the_begin_though_it_is_older() -> None:
    ring = Ring(span=60.0)
    for second, topic in ((0, "/battery_level"), (1, "/battery_level"), (2, "/rosout")):
        ring.add(heard(second, topic, str(second)), second)
    ring.add(heard(100, "/rosout", "now"), 100)
    kept = ring.subscribe(nobody)
    assert [one.message.data for one in kept] == ["1", "now"]
    assert {one.time for one in kept} == {100 * 10**9}


def test_a_listener_gets_what_follows_its_copy_and_nothing_twice() -> None:
    ring, more = Ring(), list[ReceivedMessage]()

    def listen(one: ReceivedMessage, _: int) -> None:
        more.append(one)

    ring.add(heard(1, text="before"), 1)
    kept = ring.subscribe(listen)
    ring.add(heard(2, text="after"), 2)
    ring.unsubscribe(listen)
    ring.add(heard(3, text="too late"), 3)
    assert [one.message.data for one in (*kept, *more)] == ["before", "after"]


def test_a_message_weighs_about_what_its_texts_and_lists_do() -> None:
    assert weight(String(data="x" * 1000)) > 1000
    assert weight([1.0] * 1000) > 8000
    assert weight(b"x" * 1000) > 1000
    assert weight(LazyMessage(lambda first, since: String(), 123)) == 123


def test_a_clock_that_is_set_pushes_nothing_out_and_keeps_nothing_for_ever() -> None:
    ring = Ring(span=60.0)
    for second in range(100):
        wall = second + (10**6 if 20 <= second < 50 else 0)
        ring.add(heard(wall, "/rosout", str(second)), second)
    assert texts(ring) == [str(second) for second in range(39, 100)]


def test_what_stands_keeps_its_time_where_nothing_else_is_kept() -> None:
    ring = Ring(max_bytes=10_000)
    ring.add(heard(50, "/battery_level", "stands"), 50)
    ring.add(heard(51, "/rosout", "x" * 20_000), 51)
    (one,) = ring.subscribe(nobody)
    assert (one.message.data, one.time) == ("stands", 50 * 10**9)


def test_what_is_too_large_does_not_stand_on() -> None:
    ring = Ring()
    ring.add(heard(1, "/map", "x" * 2_000_000), 1)
    ring.add(heard(100, "/rosout", "now"), 100)
    assert texts(ring) == ["now"]
