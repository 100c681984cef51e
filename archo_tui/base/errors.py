"""The base of errors that a user can mend: one line each, never a traceback."""


class ArchoError(Exception):
    """An error that the user can mend; the message says in one line what, where and what to do."""


class UserFileError(ArchoError):
    """An error in a file of the user's own."""

    def __init__(self, text: str, report: str = "") -> None:
        """Create the error; the `report` is for the file's author, "" if it would say no more."""
        super().__init__(text)
        self.report = report


def first_line(error: BaseException) -> str:
    """Return the first line of an error's text; "" if it has none."""
    return (str(error).splitlines() or [""])[0]


def quoted_line(line: str) -> str:
    """Return a line of code as messages end with it, `, in: x = y + 1`; "" for a blank one."""
    return f", in: {line.strip()}" if line.strip() else ""


def in_one_line(error: BaseException) -> str:
    """Return the first line of an error; other errors than ours begin with their type's name."""
    text = first_line(error)
    return text if isinstance(error, ArchoError) else f"{type(error).__name__}: {text}".rstrip(": ")
