"""Nodes that run in this process: started, stopped, reloaded."""
