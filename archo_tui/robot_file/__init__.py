"""Robot files: the description of a robot's topics, actions and services that `--robot` names."""
