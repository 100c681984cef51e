"""The entry point of `python -m archo_tui`."""

import sys

from archo_tui.cli import main

sys.exit(main())
