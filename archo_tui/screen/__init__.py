"""The screen: the app, its panels, dialogs and commands, and the terminal."""
