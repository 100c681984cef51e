# Made by archo_tui.embedded.stubs from the interface files; a test keeps it fresh.
