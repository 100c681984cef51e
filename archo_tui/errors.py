"""The root of what goes wrong by a user's doing: one line, never a traceback."""


class ArchoError(Exception):
    """A mistake or lack that the user can mend; the message says what, where and what to do."""
