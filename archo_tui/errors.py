"""The base of errors that a user can mend: one line each, never a traceback."""


class ArchoError(Exception):
    """An error that the user can mend; the message says what, where and what to do."""


def in_one_line(error: BaseException) -> str:
    """Return an error as one line; other errors than ours begin with the name of their type."""
    text = (str(error).splitlines() or [""])[0]
    return text if isinstance(error, ArchoError) else f"{type(error).__name__}: {text}".rstrip(": ")
