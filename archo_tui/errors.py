"""The root of what goes wrong by a user's doing: one line, never a traceback."""


class ArchoError(Exception):
    """A mistake or lack that the user can mend; the message says what, where and what to do."""


def in_one_line(error: BaseException) -> str:
    """What went wrong, in one line: ours in its own words, another after the name of its type."""
    text = (str(error).splitlines() or [""])[0]
    return text if isinstance(error, ArchoError) else f"{type(error).__name__}: {text}".rstrip(": ")
