"""The node motor_controller, which drives to a shelf, counts ticks and stops in an emergency."""

from __future__ import annotations

from typing import Any

import rclpy
from archo_interfaces.action import MoveToShelf
from archo_interfaces.msg import BatteryStatus, MotorStatus
from archo_interfaces.srv import EmergencyStop, ResetEncoder
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.clock import Clock, ClockType
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.task import Future
from std_srvs.srv import Trigger

from archo_bringup import motion
from archo_bringup.parameters import double, fixed, integer

STATUS_PERIOD = 0.2  # Seconds between two motor_status messages.

# The ends of a move, by the goal handle's method for each.
ARRIVED, CANCELED, ABORTED = "succeed", "canceled", "abort"


class MotorController(Node):
    """A node with action `move_to_shelf`, topic `motor_status`, and services to reset and stop."""

    def __init__(self, **options: Any) -> None:
        super().__init__("motor_controller", enable_logger_service=True, **options)
        self.declare_parameter("max_speed", *double(0.8, "m/s along the route", 0.05, 2.0))
        self.declare_parameter("wheel_radius", *double(0.05, "m", 0.01, 0.5))
        self.declare_parameter(
            "feedback_period", *double(0.5, "s between two feedbacks", 0.02, 5.0)
        )
        self.declare_parameter(
            "route_length", *double(18.0, "m from here to any shelf", 0.1, 1000.0)
        )
        self.declare_parameter(
            "time_scale", *double(7.5, "simulated seconds per real second", 0.1, 100.0)
        )
        self.declare_parameter("shelf_count", *integer(40, "shelves are 1 .. this", 1, 9999))
        self.declare_parameter(
            "ticks_per_revolution", *fixed(1024, "encoder ticks of one turn of a wheel")
        )
        self.add_post_set_parameters_callback(self.apply_feedback_period)

        self.drive = motion.Drive()
        self.clock = Clock(clock_type=ClockType.STEADY_TIME)
        self.goal: Any = None  # The goal that is being driven.
        self.shelf = 0  # The target of the goal.
        self.outcome: Future[tuple[str, str]] = Future()  # How the goal ended, and its message.
        self.emergency_stopped = False
        self.battery_empty = False
        self.steps = motion.Steps(0, 1)
        self.status_publisher = self.create_publisher(MotorStatus, "motor_status", 10)
        self.create_subscription(BatteryStatus, "battery_level", self.on_battery, 10)
        self.create_service(ResetEncoder, "reset_encoder", self.reset_encoder)
        self.create_service(EmergencyStop, "emergency_stop", self.emergency_stop)
        self.create_service(Trigger, "release_emergency_stop", self.release_emergency_stop)
        self.create_timer(STATUS_PERIOD, self.publish_status)
        self.control_timer = self.create_timer(self.value("feedback_period"), self.control)
        self.control_timer.cancel()  # The timer runs during a move only.
        self.action_server = ActionServer(
            self,
            MoveToShelf,
            "move_to_shelf",
            self.execute_move,
            goal_callback=self.on_goal,
            cancel_callback=self.on_cancel,
        )

    def value(self, name: str) -> float:
        return float(self.get_parameter(name).value)

    # The move.

    def on_goal(self, request: MoveToShelf.Goal) -> GoalResponse:
        reason = self.why_not(request.shelf_number)
        if reason:
            self.get_logger().warning(f"Goal refused: {reason}")
            return GoalResponse.REJECT
        self.goal = request  # Taken from now on; the handle follows in execute_move.
        self.shelf = request.shelf_number
        self.drive.begin(self.value("route_length"))
        self.outcome = Future()
        return GoalResponse.ACCEPT

    def why_not(self, shelf: int) -> str:
        """Return why a goal to that shelf is refused, or an empty string."""
        shelves = int(self.value("shelf_count"))
        if self.emergency_stopped:
            return "emergency stop: release it first"
        if self.battery_empty:
            return "battery empty"
        if self.goal is not None:
            return "a goal is already running"
        if not 1 <= shelf <= shelves:
            return f"shelf {shelf} is not in 1 .. {shelves}"
        return ""

    async def execute_move(self, goal: Any) -> MoveToShelf.Result:
        shelf = goal.request.shelf_number
        self.get_logger().info(f"Moving to shelf {shelf}")
        self.goal = goal
        self.start_control_timer()
        self.publish_status()
        how, message = await self.outcome
        self.control_timer.cancel()
        self.goal = None
        getattr(goal, how)()
        self.get_logger().info(message)
        self.publish_status()
        return MoveToShelf.Result(success=how == ARRIVED, final_message=message)

    def start_control_timer(self) -> None:
        period_ns = int(self.value("feedback_period") * 1e9)
        self.steps = motion.Steps(self.clock.now().nanoseconds, period_ns)
        self.control_timer.timer_period_ns = period_ns
        self.control_timer.reset()

    def control(self) -> None:
        """Run one control period: take a cancel, else drive on and report."""
        if self.goal.is_cancel_requested:
            self.end(CANCELED, "Cancelled mid-route")
        # A late timer makes up for the periods it missed, so that speed follows the clock. A
        # process that was suspended does not.
        for _ in range(self.steps.due(self.clock.now().nanoseconds)):
            if self.outcome.done():
                return
            period = self.value("feedback_period") * self.value("time_scale")
            per_metre = motion.ticks_per_metre(
                self.value("wheel_radius"), int(self.value("ticks_per_revolution"))
            )
            there = self.drive.advance(self.value("max_speed") * period, per_metre)
            self.goal.publish_feedback(
                MoveToShelf.Feedback(distance_remaining=self.drive.remaining, status="moving")
            )
            if there:
                self.end(ARRIVED, f"Arrived at shelf {self.goal.request.shelf_number}")
        self.publish_status()

    def on_cancel(self, goal: Any) -> CancelResponse:
        return CancelResponse.REJECT if self.outcome.done() else CancelResponse.ACCEPT

    def end(self, how: str, message: str) -> None:
        """End the move; the first end counts."""
        if self.goal is not None and not self.outcome.done():
            self.outcome.set_result((how, message))

    # Stop, encoder, battery.

    def emergency_stop(
        self, request: EmergencyStop.Request, response: EmergencyStop.Response
    ) -> EmergencyStop.Response:
        self.emergency_stopped = True
        left = f"{self.drive.remaining:.1f} m before shelf {self.shelf}"
        self.end(ABORTED, f"Emergency stop, {left}")
        self.publish_status()
        self.get_logger().warning("Emergency stop")
        response.success, response.message = True, "Stopped"
        return response

    def release_emergency_stop(
        self, request: Trigger.Request, response: Trigger.Response
    ) -> Trigger.Response:
        self.emergency_stopped = False
        self.publish_status()
        self.get_logger().info("Emergency stop released")
        response.success, response.message = True, "Released; nothing resumes by itself"
        return response

    def reset_encoder(
        self, request: ResetEncoder.Request, response: ResetEncoder.Response
    ) -> ResetEncoder.Response:
        ticks = self.drive.reset_encoder()
        self.get_logger().info(f"Encoder reset from {ticks} ticks")
        self.publish_status()
        response.success, response.message = True, "Encoder reset to zero"
        return response

    def on_battery(self, message: BatteryStatus) -> None:
        self.battery_empty = message.percentage <= 0.0
        if self.battery_empty:
            self.end(ABORTED, "Battery empty")

    def publish_status(self) -> None:
        moving = self.goal is not None and not self.outcome.done()
        self.status_publisher.publish(
            MotorStatus(
                encoder_ticks=self.drive.encoder_ticks,
                speed=self.value("max_speed") if moving else 0.0,
                moving=moving,
                emergency_stopped=self.emergency_stopped,
            )
        )

    def apply_feedback_period(self, parameters: list[Parameter[Any]]) -> None:
        if any(p.name == "feedback_period" for p in parameters) and self.goal is not None:
            self.start_control_timer()


def main(args: list[str] | None = None) -> None:
    rclpy.init(args=args)
    try:
        rclpy.spin(MotorController())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
