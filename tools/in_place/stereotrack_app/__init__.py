"""The folder ``app`` of this checkout under the name that it has when it is installed."""

from pathlib import Path

__path__ = [str(Path(__file__).resolve().parents[3] / "app")]
