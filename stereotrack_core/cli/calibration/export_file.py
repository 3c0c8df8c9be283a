"""``stereotrack calibrate export``: ``calibration.toml`` for another tool."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from stereotrack_core.cli.arguments import JSON, check_output, check_suffix, option
from stereotrack_core.cli.output import OK, put_result
from stereotrack_core.errors import InputError
from stereotrack_core.interop.calibrations.foreign import METRES_PER_UNIT
from stereotrack_core.interop.calibrations.formats import UNITS_OF_EXPORT, write_foreign
from stereotrack_core.recording.calibration import read_calibration
from stereotrack_core.tables import Table

DESCRIPTION = (
    "Write a calibration for another tool. What this program reads again is the same; tools that "
    "know fewer distortion coefficients or no names may lose some of it."
)

OPTIONS = (
    option("calibration CALIBRATION", "calibration.toml to read", type=Path),
    option(
        "-o --output FILE",
        "file to write: .toml, or .yml, .yaml or .xml for OpenCV",
        type=Path,
        required=True,
    ),
    option(
        "--format NAME",
        f"{', '.join(UNITS_OF_EXPORT)} (default: opencv for .yml, .yaml and .xml; aniposelib for "
        ".toml)",
        choices=tuple(UNITS_OF_EXPORT),
    ),
    option(
        "--units UNIT",
        "unit of lengths: m, cm, mm or in (default: mm for freemocap, else m)",
        choices=tuple(METRES_PER_UNIT),
    ),
    JSON,
)

_OPENCV = (".yml", ".yaml", ".xml")


def run(args: Namespace) -> int:
    """Read and write."""
    opencv = args.output.suffix.lower() in _OPENCV
    form = args.format or ("opencv" if opencv else "aniposelib")
    check_suffix(args.output, *(_OPENCV if form == "opencv" else (".toml",)))
    check_output(args.output)
    if args.output.resolve() == args.calibration.resolve():
        raise InputError(
            "this is the calibration that is read",
            where=str(args.output),
            remedy="Choose another name.",
        )
    cameras = read_calibration(args.calibration)
    unit = args.units or UNITS_OF_EXPORT[form]
    write_foreign(args.output, list(cameras.values()), form, unit)
    facts = {"file": args.output, "format": form, "units": unit, "cameras": list(cameras)}
    rows = [("format", form), ("units", unit), ("cameras", ", ".join(cameras))]
    table = Table(f"{args.calibration} to {args.output}", ("", ""), rows)
    put_result(facts, table, as_json=args.json)
    return OK
