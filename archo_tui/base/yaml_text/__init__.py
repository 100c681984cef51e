"""YAML text: a reader that always ends, and a writer that YAML 1.1 and 1.2 read alike."""
