"""A rover: nested messages, a battery of 0 .. 1, no STOP; and nodes without a robot file."""

from __future__ import annotations

from functools import partial
from typing import Any

from depot_interfaces.action import Dock, Fibonacci, GoTo, Inspect
from depot_interfaces.msg import Charge, Odometry
from depot_interfaces.srv import Plan
from rclpy.action import ActionServer, CancelResponse
from rclpy.node import Node
from rclpy.task import Future

from tests.support.stand_in import Drive

FULL = 4  # POWER_SUPPLY_STATUS_FULL of sensor_msgs/msg/BatteryState


class Rover(Node):
    """`heard` holds the targets of its goals; while it `is_held`, it comes no nearer to one."""

    def __init__(self, **options: Any) -> None:
        super().__init__("rover", **options)
        self.drive = Drive(self, GoTo, "go_to", "distance_remaining")
        self.celsius, self.docked, self.speed = 31.5, False, 0.3
        self.is_full, self.turning, self.is_held = False, 0.0, False
        self._battery = self.create_publisher(Charge, "battery_state", 10)
        self._odometry = self.create_publisher(Odometry, "odom", 10)
        ActionServer(self, Dock, "dock", lambda goal: self._dock(goal, True))
        ActionServer(self, Dock, "undock", lambda goal: self._dock(goal, False))
        self.create_timer(0.1, self._tick)

    def _tick(self) -> None:
        status = Charge.STATUS_CHARGING if self.docked else Charge.STATUS_DISCHARGING
        if self.is_full:
            status = FULL
        said = Charge(fraction=0.75, volts=14.5, status=status, celsius=self.celsius)
        self._battery.publish(said)
        odometry = Odometry()
        odometry.angular.z = self.turning
        odometry.linear.x = self.speed if self.drive.goal is not None else 0.0
        self._odometry.publish(odometry)
        self.drive.step = 0.0 if self.is_held else 0.5

    @property
    def heard(self) -> list[Any]:
        return [request.target for request in self.drive.requests]

    def _dock(self, goal: Any, docked: bool) -> Any:
        self.docked = docked
        goal.succeed()
        return Dock.Result(is_docked=docked)


class Counting(Node):
    """Fibonacci, one number each 0.2 s; an inspection; and a planner."""

    def __init__(self, **options: Any) -> None:
        super().__init__("counting", **options)
        self.planned: list[Any] = []
        self.inspected: list[Any] = []
        ActionServer(
            self,
            Fibonacci,
            "fibonacci",
            self._count,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )
        ActionServer(self, Inspect, "inspect", self._inspect)
        self.create_service(Plan, "plan", self._plan)

    async def _count(self, goal: Any) -> Any:
        numbers = [0, 1]
        while len(numbers) <= goal.request.order:
            passed: Any = Future(executor=self.executor)
            timer = self.create_timer(0.2, partial(passed.set_result, True))
            await passed
            self.destroy_timer(timer)
            if goal.is_cancel_requested:
                goal.canceled()
                return Fibonacci.Result(sequence=numbers)
            numbers.append(numbers[-1] + numbers[-2])
            goal.publish_feedback(Fibonacci.Feedback(sequence=numbers))
        goal.succeed()
        return Fibonacci.Result(sequence=numbers)

    def _inspect(self, goal: Any) -> Any:
        self.inspected.append(goal.request)
        goal.succeed()
        return Inspect.Result(seen=len(goal.request.labels))

    def _plan(self, request: Any, response: Any) -> Any:
        self.planned.append(request)
        response.legs, response.route = len(request.waypoints), "by the wall"
        return response
