"""What the terminal sends and shows: keys, pastes, signals, hang-ups."""
