"""STOP: the gate that voids what came before it, and the machine of its rules."""
