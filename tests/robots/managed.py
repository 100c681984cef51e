"""A managed node that serves a goal, and may reject to be activated."""

from __future__ import annotations

from typing import Any

from archo_interfaces.action import MoveToShelf
from archo_interfaces.srv import EmergencyStop
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.task import Future

from tests.support.stand_in import Drive


class Navigator(LifecycleNode):
    """It takes goals while it is active; `may_activate` is what it answers to activate."""

    def __init__(self, **options: Any) -> None:
        super().__init__("navigator", **options)
        self.is_active, self.may_activate = False, True
        self.create_service(EmergencyStop, "emergency_stop", lambda _, response: response)
        self.drive = Drive(
            self,
            MoveToShelf,
            "move_to_shelf",
            "distance_remaining",
            way=12.0,
            step=0.0,
            accepts=lambda _: self.is_active,
            result=lambda how: {"success": how == "succeed"},
        )

    def hang(self) -> None:
        """Answer no question about the state any more."""
        for service in list(self.services):
            if service.srv_name.endswith(("get_state", "get_available_transitions")):
                service.callback = self._never

    async def _never(self, _: Any, response: Any) -> Any:
        await Future(executor=self.executor)
        return response

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        if not self.may_activate:
            return TransitionCallbackReturn.FAILURE
        self.is_active = True
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.is_active = False
        return super().on_deactivate(state)
