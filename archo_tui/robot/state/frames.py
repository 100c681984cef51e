"""The transforms that were received lately, and what is wrong with them in words. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from math import inf
from typing import Any, NamedTuple

from archo_tui.base.clock import Monotonic
from archo_tui.base.safe_text import harmless
from archo_tui.robot.messages.period import MessageRate

LATELY = 10.0  # Seconds for which a parent counts that is published no more.
_AHEAD = 0.5  # Seconds that a stamp may lie in the future: clocks differ.
_NAMED = 3  # Frames of a part of the tree that are named.
MOST_FRAMES = 1000  # More are no robot's.


class Frame(NamedTuple):
    """A frame, as the transforms to it tell; immutable."""

    name: str
    parent: str  # Of the last transform.
    # When each parent was heard last, in monotonic seconds; infinite for a static transform.
    parents: Mapping[str, Monotonic]
    rate: MessageRate
    # Seconds from the last stamp to its receipt; negative for one in the future, 0 if not known.
    behind: float
    is_static: bool

    def parents_at(self, now: float) -> list[str]:
        """Return the parents that were heard lately."""
        return sorted(name for name, heard in self.parents.items() if now - heard <= LATELY)

    def age(self, now: float) -> float | None:
        """Return the seconds since the last stamp; None for a static frame, which stays valid."""
        return None if self.is_static else now - self.rate.heard + max(self.behind, 0.0)


class Transforms(NamedTuple):
    """All frames by name, and who publishes them."""

    frames: Mapping[str, Frame] = {}
    publishers: tuple[str, ...] = ()  # The nodes that publish /tf.
    static_publishers: tuple[str, ...] = ()  # The nodes that publish /tf_static.
    fault: str = ""  # Why they cannot be read.

    def publishers_of(self, frame: Frame) -> tuple[str, ...]:
        """Return the nodes that may publish a frame: the graph tells no more."""
        return self.static_publishers if frame.is_static else self.publishers


def with_transforms(
    frames: Mapping[str, Frame],
    received: Iterable[Any],
    now: float,
    wall_time: float | None,
    *,
    is_static: bool,
) -> dict[str, Frame]:
    """Return the frames with a message's TransformStamped; `wall_time` None: stamps tell no age."""
    found = dict(frames)
    for transform in received:
        name, parent = harmless(transform.child_frame_id), harmless(transform.header.frame_id)
        old = found.get(name)
        if old is None and len(found) >= MOST_FRAMES:
            continue
        stamp = transform.header.stamp.sec + transform.header.stamp.nanosec / 1e9
        parents = {} if old is None else {p: old.parents[p] for p in old.parents_at(now)}
        found[name] = Frame(
            name,
            parent,
            {**parents, parent: inf if is_static else now},
            MessageRate(now) if old is None else old.rate.with_message_at(now),
            0.0 if wall_time is None or not stamp else wall_time - stamp,
            is_static,
        )
    return found


def faults(transforms: Transforms, now: float) -> Iterator[str]:
    """Yield what is wrong with the tree and its stamps, a sentence each."""
    frames = sorted(transforms.frames.values())
    for frame in frames:
        parents = frame.parents_at(now)
        if len(parents) > 1:
            names = f"{', '.join(parents[:-1])} and {parents[-1]}"
            yield f"{frame.name} has {len(parents)} parents, {names}: a frame has one"
        if not frame.is_static and frame.behind < -_AHEAD:
            ahead = f"{-frame.behind:.1f} s in the future"
            yield f"the stamp of {frame.name} is {ahead}: compare the clocks"
    parts = _parts(frames, now)
    if len(parts) > 1:
        texts = "; ".join(_part_text(sorted(part)) for part in parts)
        yield f"the tree is in {len(parts)} parts, no transform joins them: {texts}"


def _parts(frames: Iterable[Frame], now: float) -> list[set[str]]:
    parts: list[set[str]] = []
    for frame in frames:
        joined = {frame.name, frame.parent, *frame.parents_at(now)}
        for part in [part for part in parts if part & joined]:
            parts.remove(part)
            joined |= part
        parts.append(joined)
    return sorted(parts, key=sorted)


def _part_text(names: list[str]) -> str:
    more = len(names) - _NAMED
    return ", ".join(names) if more <= 0 else f"{', '.join(names[:_NAMED])} and {more} more"
