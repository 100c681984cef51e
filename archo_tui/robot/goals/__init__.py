"""Goals: the machine of their rules, and the client of their actions."""
