"""STOP: the gate that voids what came before it, the machine of its rules, and its sender."""
