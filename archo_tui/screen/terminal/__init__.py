"""The console's terminal: its driver, keys, pastes, colours and ASCII."""
