"""`rclpy.subscription_content_filter_options`: which messages a subscription wants."""

from __future__ import annotations

from typing import NamedTuple


class ContentFilterOptions(NamedTuple):
    """A DDS filter expression, and the literals for its `%0`, `%1` and so on."""

    filter_expression: str
    expression_parameters: list[str]
