"""Whole paths through tmux and sshd; only with --end-to-end, which needs both installed."""
