"""The conditions of `launch.conditions`."""

from __future__ import annotations

from dataclasses import dataclass

from archo_tui.launch.stand_ins.core import (
    Condition,
    LaunchContext,
    SubstitutionFailure,
    Text,
    perform,
)


@dataclass(eq=False)
class IfCondition(Condition):
    """The condition that an expression is `true` or `1`; it does not hold for `false` or `0`.

    Any other text raises SubstitutionFailure.
    """

    predicate_expression: Text

    def evaluate(self, context: LaunchContext) -> bool:
        text = perform(context, self.predicate_expression).strip().lower()
        if text not in ("true", "1", "false", "0"):
            wanted = "true, 1, false or 0 is wanted"
            raise SubstitutionFailure(f"a condition is {text!r}: {wanted}", self.place)
        return text in ("true", "1")


class UnlessCondition(IfCondition):
    """The opposite of IfCondition: it holds for `false` and `0`."""

    def evaluate(self, context: LaunchContext) -> bool:
        return not super().evaluate(context)


@dataclass(eq=False)
class LaunchConfigurationEquals(Condition):
    """The condition that a launch configuration has a value; for None, that it is not set."""

    launch_configuration_name: str
    expected_value: Text | None

    def evaluate(self, context: LaunchContext) -> bool:
        name, wanted = self.launch_configuration_name, self.expected_value
        context.read.add(name)
        expected = None if wanted is None else perform(context, wanted)
        return bool(context.launch_configurations.get(name) == expected)


class LaunchConfigurationNotEquals(LaunchConfigurationEquals):
    """The opposite of LaunchConfigurationEquals; for None, that a launch configuration is set."""

    def evaluate(self, context: LaunchContext) -> bool:
        return not super().evaluate(context)
