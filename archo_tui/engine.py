"""What `import rclpy` means in this process; chosen once, before anything imports it."""

from __future__ import annotations

from pathlib import Path

from archo_tui import embedded
from archo_tui.errors import ArchoError

ENGINES = ("embedded",)

_CHECKOUT = Path(__file__).parent.parent


def activate(name: str) -> None:
    """Make `import rclpy` mean the named engine.

    Raises ArchoError for an engine that this build does not have, and when another `rclpy` is
    imported already. Never falls back to another engine.
    """
    if name not in ENGINES:
        raise ArchoError(f"no engine {name!r}: this build has only the embedded engine")
    try:
        embedded.install(interface_packages())
    except RuntimeError as error:
        raise ArchoError(f"cannot use the embedded engine: {error}") from None


def interface_packages() -> dict[str, Path]:
    """Interface packages beside those that the engine brings: in a checkout, `interfaces/`.

    An installed wheel carries them in the engine's own `share/` folder.
    """
    folder = _CHECKOUT / "interfaces"
    return {"archo_interfaces": folder} if (folder / "package.xml").is_file() else {}
