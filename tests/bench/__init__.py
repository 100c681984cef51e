"""Measurements, not run with the tests: figures are judged by a person, on a quiet machine."""
