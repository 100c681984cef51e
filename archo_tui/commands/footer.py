"""The keys that the footer of a console shows."""

from __future__ import annotations

from archo_tui.commands.base import EVERYWHERE, Console
from archo_tui.widgets.bars import FooterKey


def blocked_commands(console: Console) -> frozenset[str]:
    """Return the ids of the commands that cannot run now."""
    return frozenset(c.id for c in console.registry if console.disabled_reason(c))


def keys_of_footer(console: Console) -> list[FooterKey]:
    """Return the commands with a footer word and a key, in the registry's order; also disabled."""
    view = console.view
    return [
        FooterKey(
            c.id,
            c.footer_key or view.key(c.id),
            c.footer,
            c.id in view.blocked,
            c.where == EVERYWHERE,
        )
        for c in console.registry
        if c.footer and (c.footer_key or view.key(c.id))
    ]
