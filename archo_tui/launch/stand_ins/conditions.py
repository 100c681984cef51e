"""The conditions of `launch.conditions`."""

from __future__ import annotations

from archo_tui.launch.stand_ins.core import (
    Condition,
    LaunchContext,
    SomeSubstitutionsType,
    SubstitutionFailure,
    normalize_to_list_of_substitutions,
    perform,
    perform_substitutions,
)

__all__ = [
    "IfCondition",
    "LaunchConfigurationEquals",
    "LaunchConfigurationNotEquals",
    "UnlessCondition",
]


class IfCondition(Condition):
    """The condition that an expression is `true` or `1`; it does not hold for `false` or `0`.

    Any other text raises SubstitutionFailure.
    """

    def __init__(self, predicate_expression: SomeSubstitutionsType) -> None:
        super().__init__(predicate=self._holds)
        self._expression = normalize_to_list_of_substitutions(predicate_expression)

    def _holds(self, context: LaunchContext) -> bool:
        text = perform_substitutions(context, self._expression).strip().lower()
        if text not in ("true", "1", "false", "0"):
            wanted = "true, 1, false or 0 is wanted"
            raise SubstitutionFailure(f"a condition is {text!r}: {wanted}", self.place)
        return text in ("true", "1")


class UnlessCondition(IfCondition):
    """The opposite of IfCondition: it holds for `false` and `0`."""

    def _holds(self, context: LaunchContext) -> bool:
        return not super()._holds(context)


class LaunchConfigurationEquals(Condition):
    """The condition that a launch configuration has a value; for None, that it is not set."""

    def __init__(
        self, launch_configuration_name: str, expected_value: SomeSubstitutionsType | None
    ) -> None:
        super().__init__(predicate=self._holds)
        self._name, self._expected = launch_configuration_name, expected_value

    def _holds(self, context: LaunchContext) -> bool:
        context.read.add(self._name)
        expected = None if self._expected is None else perform(context, self._expected)
        return bool(context.launch_configurations.get(self._name) == expected)


class LaunchConfigurationNotEquals(LaunchConfigurationEquals):
    """The opposite of LaunchConfigurationEquals; for None, that a launch configuration is set."""

    def _holds(self, context: LaunchContext) -> bool:
        return not super()._holds(context)
