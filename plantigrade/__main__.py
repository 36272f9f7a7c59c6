"""Run the command line with ``python -m plantigrade``."""

import sys

from plantigrade.commands.main import main

if __name__ == "__main__":
    sys.exit(main())
