"""The operator's side without a screen: station, queue, alarms, history, journal, undo."""
