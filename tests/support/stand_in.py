"""A robot of which a test says what it does: STOP and its release, goals, and what it reports."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, TypeVar

from archo_interfaces.action import MoveToShelf
from archo_interfaces.msg import MotorStatus
from archo_interfaces.srv import EmergencyStop
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import Float32
from std_srvs.srv import Trigger

from tests.support import clock
from tests.support.ros import begin

N = TypeVar("N", bound=Node)


class Made(Generic[N]):
    """Makes a node of a class when it is called, and keeps it as `node`."""

    node: N

    def __init__(self, kind: Callable[..., N], *given: Any, **fixed: Any) -> None:
        self._kind, self._given, self._fixed = kind, given, fixed

    def __call__(self, **options: Any) -> N:
        self.node = self._kind(*self._given, **self._fixed, **options)
        return self.node


class StandIn(Node):
    """Answers STOP and its release with "yes", "no" or, until it is woken, "nothing".

    It serves neither of them if that is "", and goals if these "arrive", or "drive" until they are
    cancelled, which `ends` them so (not while it `drives_on`). It `decides` about a goal after as
    many seconds, and rejects it unless it `accepts`. It reports its motion unless that is None,
    else a battery.
    """

    def __init__(
        self,
        name: str = "robot",
        stop: str = "",
        *,
        release: str = "",
        goals: str = "",
        decides: float | None = None,
        ends: str = "canceled",
        seconds: float = 0.0,
        feeds: bool = False,
        heeds: bool = True,
        latches: bool = False,
        moving: bool | None = None,
        **options: Any,
    ) -> None:
        super().__init__(name, **options)
        self.says, self.releases, self.goals = stop, release, goals
        self.seconds, self.feeds, self.heeds, self.latches = seconds, feeds, heeds, latches
        self.moving, self.stopped, self.is_silent = moving, False, False
        self.ends, self.accepts, self._decides, self.drives_on = ends, True, decides, False
        self.stops: list[float] = []  # When each was asked for, and so of the cancels.
        self.cancels: list[float] = []
        self.asked_to_release = 0
        self.running: list[Any] = []
        self.asked: list[int] = []  # The shelves of all goals, and of those that were accepted.
        self.shelves: list[int] = []
        self.awake: Future[bool] = Future()
        self._group = group = ReentrantCallbackGroup()
        self.service: Any = None
        if stop:
            self.offer_stop()
        if release:
            self.create_service(
                Trigger, "release_emergency_stop", self._release, callback_group=group
            )
        if goals:
            self.action = ActionServer(
                self,
                MoveToShelf,
                "move_to_shelf",
                self._drive,
                callback_group=group,
                goal_callback=self._decide,
                cancel_callback=self._cancel,
            )
        kind, topic = (
            (Float32, "battery_level") if moving is None else (MotorStatus, "motor_status")
        )
        self.report: Any = self.create_publisher(kind, topic, 10)
        self.create_timer(0.2, self._tell, callback_group=group)

    def offer_stop(self) -> None:
        self.service = self.create_service(
            EmergencyStop, "emergency_stop", self._stop, callback_group=self._group
        )

    def wake(self) -> None:
        """Have what waits answered."""
        if not self.awake.done():
            begin(self, lambda: self.awake.set_result(True))

    def leave(self) -> None:
        """Leave the graph, as the death of its process does."""
        if self.executor is not None:
            self.executor.remove_node(self)
        if self.goals:
            self.action.destroy()  # rclpy leaves it on the graph when its node is destroyed.
        self.destroy_node()

    async def sleep(self, seconds: float) -> None:
        over: Future[bool] = Future(executor=self.executor)
        timer = self.create_timer(seconds, lambda: over.set_result(True))
        await over
        self.destroy_timer(timer)

    async def _stop(self, _: Any, response: Any) -> Any:
        self.stops.append(clock.seconds())
        return await self._answer(self.says, response, stopped=True)

    async def _release(self, _: Any, response: Any) -> Any:
        self.asked_to_release += 1
        return await self._answer(self.releases, response, stopped=False)

    async def _answer(self, says: str, response: Any, *, stopped: bool) -> Any:
        if says == "nothing":
            await self.awake
        if stopped and self.seconds:
            await self.sleep(self.seconds)
        if says != "no" and self.latches:
            self.stopped = stopped
        response.success, response.message = says != "no", f"{self.get_name()} {says}"
        return response

    async def _decide(self, request: Any) -> GoalResponse:
        self.asked.append(request.shelf_number)
        if self._decides is not None:
            await self.sleep(self._decides)
        return GoalResponse.ACCEPT if self.accepts else GoalResponse.REJECT

    def _cancel(self, _: Any) -> CancelResponse:
        self.cancels.append(clock.seconds())
        return CancelResponse.ACCEPT if self.heeds else CancelResponse.REJECT

    async def _drive(self, goal: Any) -> MoveToShelf.Result:
        self.shelves.append(goal.request.shelf_number)
        if self.goals == "arrive":
            goal.succeed()
            return MoveToShelf.Result(success=True)
        self.running.append(goal)
        while self.drives_on or not goal.is_cancel_requested:
            await self.sleep(0.1)
        self.running.remove(goal)
        getattr(goal, self.ends)()
        return MoveToShelf.Result(success=self.ends == "succeed", final_message="called back")

    def _tell(self) -> None:
        if self.moving is None:
            self.report.publish(Float32(data=80.0))
        elif not self.is_silent:
            self.report.publish(MotorStatus(moving=self.moving, emergency_stopped=self.stopped))
        for goal in self.running if self.feeds else ():
            goal.publish_feedback(MoveToShelf.Feedback(distance_remaining=9.0))


class Drive:
    """An action of a node, which comes a step nearer each 0.1 s until it is there or is ended."""

    def __init__(
        self,
        node: Node,
        kind: Any,
        name: str,
        left: str = "",  # the field of its feedback
        *,
        way: float = 5.0,
        step: float = 0.5,
        accepts: Callable[[Any], object] = lambda _: True,
        result: Callable[[str], dict[str, Any]] = lambda how: {},
        told: Callable[[str], object] = lambda how: None,  # "" when it begins
    ) -> None:
        self.node, self.kind, self.field = node, kind, left
        self.way, self.step, self.result, self.told = way, step, result, told
        self.requests: list[Any] = []
        self.left, self.goal = 0.0, None
        self._end: Any = None
        ActionServer(
            node,
            kind,
            name,
            self._execute,
            goal_callback=lambda goal: (
                GoalResponse.ACCEPT if accepts(goal) else GoalResponse.REJECT
            ),
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )
        node.create_timer(0.1, self._step)

    def end(self, how: str) -> None:
        """End the goal that runs by "succeed", "abort" or "canceled"."""
        if self.goal is not None and not self._end.done():
            self._end.set_result(how)

    def _step(self) -> None:
        goal: Any = self.goal
        if goal is None or self._end.done():
            return
        if goal.is_cancel_requested:
            self.end("canceled")
            return
        if self.field:
            goal.publish_feedback(self.kind.Feedback(**{self.field: self.left}))
        self.left -= self.step
        if self.left < 0.0:
            self.end("succeed")

    async def _execute(self, goal: Any) -> Any:
        self.requests.append(goal.request)
        self._end = Future(executor=self.node.executor)
        self.left, self.goal = self.way, goal
        self.told("")
        how = await self._end
        self.goal = None
        getattr(goal, how)()
        self.told(how)
        return self.kind.Result(**self.result(how))


class Other(Node):
    """Another client, which sends goals of its own; `told` is how they ended, `sent` the last."""

    def __init__(self, **options: Any) -> None:
        super().__init__("other", **options)
        self.told: list[int] = []
        self.sent: Any = None
        self.client = ActionClient(self, MoveToShelf, "move_to_shelf")

    def go(self, goals: int = 1, *, shelf: int = 1) -> None:
        """Send goals to that shelf and those behind it."""
        begin(self, self._go, goals, shelf)

    def _go(self, goals: int, shelf: int) -> None:
        for number in range(goals):
            sent = self.client.send_goal_async(MoveToShelf.Goal(shelf_number=shelf + number))
            sent.add_done_callback(self._answered)

    def _answered(self, sent: Any) -> None:
        self.sent = sent.result()
        result = self.sent.get_result_async()
        result.add_done_callback(lambda done: self.told.append(done.result().status))

    @property
    def ended(self) -> int:
        """How many of its goals have ended."""
        return len(self.told)


def beside(host: Node, node: N) -> N:
    """Have a node spun by the thread of another one: no host of this process knows it."""
    assert host.executor is not None
    begin(host, host.executor.add_node, node)
    return node
