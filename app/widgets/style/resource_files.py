"""Where icons, themes and other data files lie."""

from __future__ import annotations

from pathlib import Path

_APP = Path(__file__).resolve().parents[2]


def resource_folder() -> Path:
    """Folder of the data files.

    An installed wheel carries them inside this package; in a checkout they stand at the top level,
    beside ``app``.

    Raises
    ------
    FileNotFoundError
        If neither is there, which means that the installation is damaged.
    """
    for folder in (_APP / "resources", _APP.parent / "resources"):
        if folder.is_dir():
            return folder
    raise FileNotFoundError(f"{_APP / 'resources'} is missing: reinstall stereotrack")


def resource_path(*parts: str) -> Path:
    """Path of one data file, such as ``resource_path("icons", "play.svg")``.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    """
    path = resource_folder().joinpath(*parts)
    if not path.is_file():
        raise FileNotFoundError(f"{path} is missing: reinstall stereotrack")
    return path
