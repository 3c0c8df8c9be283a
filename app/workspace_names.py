"""Names of the workspaces, known without Qt."""

from __future__ import annotations

from stereotrack_core.errors import InputError

WORKSPACE_NAMES = ("annotate", "track", "review", "tune", "calibrate")


def check_workspace_name(name: str | None) -> None:
    """Refuse a name that no workspace has.

    Raises
    ------
    InputError
        With the names that there are.
    """
    if name is not None and name.strip().lower() not in WORKSPACE_NAMES:
        raise InputError(
            f"there is no workspace {name!r}",
            where="--workspace",
            remedy=f"Available: {', '.join(WORKSPACE_NAMES)}.",
        )
