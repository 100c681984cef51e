"""A topic while somebody looks at it: its messages counted, decoded, as rows and as curves."""
