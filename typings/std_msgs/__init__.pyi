# Made by tests.stubs from the interface files; a test keeps it fresh.
