#!/usr/bin/env python3
import my_cpp.steps  # noqa: F401
