"""The panel of motion: the robot's motion, its gauges, its commands and STOP."""

from __future__ import annotations

from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.content import Content

from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot_file.model import RobotFile
from archo_tui.screen.widgets.field import Button
from archo_tui.screen.widgets.line import Line, aligned, content
from archo_tui.screen.widgets.panel import Panel, ScreenState
from archo_tui.text.state import (
    PLAIN,
    STOPPED,
    gauge_line,
    motion_age,
    motion_line,
    motion_word,
    pose_line,
)


class MotionPanel(Panel, can_focus=True):
    """The panel with speed, state, pose and gauges, and the buttons of a command and STOP.

    The first one is the robot file's first command that switches no state of the battery; without a
    STOP service the second one is `Cancel all`.
    """

    title_text, place = "Motion", "left"

    @classmethod
    def title_for(cls, robot: RobotFile) -> str:
        return cls.title_text if robot.motion is None else robot.motion.title

    def __init__(self, snapshot: Snapshot) -> None:
        super().__init__(snapshot)
        robot = snapshot.file
        self._topic = "" if robot.motion is None else robot.motion.topic
        ours = [command for command in robot.commands if not command.toggles_reading_of("battery")]
        words = [(command.id, command.title.partition(" ")[0].lower()) for command in ours]
        stops = [("stop", "cancel all")]  # without a STOP that is all that its key does
        if robot.stop is not None:
            stops = [("stop", "stop"), *[("release", "release")][: bool(robot.stop.release)]]
        self.keys = (*words[:1], *stops, *words[1:])
        self._has_pose = robot.pose is not None
        self._line, self._word = Line(id="motion-line"), Line(id="motion-word")
        self._pose = Line(classes="gauge")
        self._gauges = [Line(classes="gauge") for _ in robot.gauges]
        stop, label = ("", "Cancel all") if robot.stop is None else (robot.stop.service, "STOP")
        self._services = [(stop, Button(label, "stop", id="stop"))]
        for command in ours[:1]:
            button = Button(command.title, command.id, id=command.id)
            self._services.insert(0, (command.service, button))

    def compose(self) -> ComposeResult:
        yield self._line
        yield self._word
        with Horizontal(classes="buttons"):
            yield from (button for _, button in self._services)
        if self._has_pose:
            yield self._pose
        yield from self._gauges  # Below STOP, which a small terminal must not cut off.

    def show(self, view: ScreenState) -> None:
        self.show_publishers(view, self._topic)
        self.show_keys(view)
        width = self._word.size.width
        line = ("", PLAIN), *motion_line(view.snapshot, view.now, width)
        self._line.show_spans(aligned(line, width))
        state = motion_word(view.snapshot, view.now, width)
        key = view.key_to_press("release")
        release = f" [u][@click=app.command('release')]({key} releases)[/][/]"
        stopped = state == STOPPED
        self._services[-1][1].set_class(stopped, "-stopped")
        self._services[-1][1].set_class(self.app.no_color, "-no-colour")  # Red would be dark.
        can_release = stopped and key and "release" not in view.blocked
        age = motion_age(view.snapshot, view.now)
        if can_release:
            whole = Content.assemble(content(state), Content.from_markup(release), content(age))
            can_release = not age or whole.cell_length <= width  # The banner names the key, too.
        if can_release:
            self._word.show(whole)
        else:
            self._word.show_spans((*state, *age))
        if self._has_pose:
            self._pose.show_spans(pose_line(view.snapshot, view.now))
        for shown, reading in zip(self._gauges, view.snapshot.gauges, strict=False):
            shown.show_spans(aligned(gauge_line(reading, view.now), width))
        self.dim_unavailable(view, self._services)
