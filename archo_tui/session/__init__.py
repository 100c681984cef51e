"""Everything but the front end: engine, nodes, robot, station, recorders and socket."""
