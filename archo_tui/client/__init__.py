"""The clients of a console that runs, for other programs; the standard library is enough."""
