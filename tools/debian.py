"""Installing packages of Debian and its relatives, where this is permitted.

``python tools/debian.py PACKAGE ...`` installs the packages, or says with which command a
person can do it and ends with status 1. Needs nothing but the standard library.
"""

import os
import shutil
import subprocess
import sys
from collections.abc import Sequence

OPTIONS = ("install", "--yes", "--no-install-recommends")


def install_command(packages: Sequence[str]) -> str:
    """Command line with which a person installs the packages."""
    return f"sudo apt-get update && sudo apt-get install {' '.join(packages)}"


def _prefix() -> list[str] | None:
    """Words before apt-get that give the right to install, None where there is none."""
    if shutil.which("apt-get") is None:
        return None
    if os.geteuid() == 0:
        return []
    sudo = shutil.which("sudo")
    if sudo is None or subprocess.run([sudo, "-n", "true"], capture_output=True).returncode != 0:
        return None
    return [sudo, "-n"]


def install(packages: Sequence[str]) -> bool:
    """Install packages without asking; False where this is not permitted or does not work."""
    prefix = _prefix()
    if prefix is None:
        return False
    apt = [*prefix, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-qq"]
    say(f"installing with apt-get: {' '.join(packages)}")
    for command in ([*apt, *OPTIONS, *packages], [*apt, "update"], [*apt, *OPTIONS, *packages]):
        # The first attempt saves the update of the lists where they are fresh enough.
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True)
        if done.returncode == 0 and "install" in command:
            return True
    sys.stderr.write(done.stderr.decode(errors="replace"))
    return False


def say(text: str) -> None:
    """One line for the person who waits, on standard error."""
    print(f"stereotrack: {text}", file=sys.stderr, flush=True)


def main(packages: Sequence[str]) -> int:
    """Install the packages; 1 and the command for a person where that is not permitted."""
    if install(packages):
        return 0
    say(f"this needs: {install_command(packages)}")
    return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
