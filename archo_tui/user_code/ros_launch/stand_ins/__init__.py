"""Stand-ins for the modules that launch files import, for the process that evaluates one."""
