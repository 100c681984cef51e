"""The lines of the transforms. Pure functions."""

from __future__ import annotations

from archo_tui.robot.state.frames import Frame, Transforms, faults

NONE = "no transform: nobody publishes /tf or /tf_static"


def transform_lines(transforms: Transforms, now: float) -> list[str]:
    """Return what is wrong, then a line such as `base_link in odom: 20.0 Hz, 0.1 s old, from a`."""
    wrong = [f"▲ {fault}" for fault in filter(None, [transforms.fault, *faults(transforms, now)])]
    lines = [_line(transforms, frame, now) for frame in sorted(transforms.frames.values())]
    if wrong or lines:
        return [*wrong, *lines]
    nodes = [*transforms.publishers, *transforms.static_publishers]
    return [f"no transform came so far from {', '.join(dict.fromkeys(nodes))}" if nodes else NONE]


def _line(transforms: Transforms, frame: Frame, now: float) -> str:
    age, hertz = frame.age(now), frame.rate.hertz_at(now)
    how = ["static"] if age is None else [f"{age:.1f} s old"]
    if age is not None and frame.rate.is_silent(now):
        how = [f"SILENT for {now - frame.rate.heard:.0f} s"]
    elif age is not None and hertz is not None:
        how = [f"{hertz:.1f} Hz", *how]
    nodes = transforms.publishers_of(frame)
    source = nodes[0] if len(nodes) == 1 else f"one of {', '.join(nodes)}"
    how += [f"from {source}"] if nodes else ["its publisher has left"]
    return f"{frame.name} in {frame.parent}: {', '.join(how)}"
