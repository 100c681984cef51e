"""The vocabulary: what is typed, pressed and asked is one."""
