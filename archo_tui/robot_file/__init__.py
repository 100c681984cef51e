"""Robots are described in a file and checked against the graph; nothing is assumed of them."""
