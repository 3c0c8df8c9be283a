"""The commands without a window: ``python -m stereotrack_core``."""

import sys

from stereotrack_core.program import main

if __name__ == "__main__":
    sys.exit(main())
