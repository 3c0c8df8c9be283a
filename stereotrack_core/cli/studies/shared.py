"""Options and steps that ``sweep`` and the commands of ``study`` share."""

from __future__ import annotations

import dataclasses
from argparse import Namespace
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from stereotrack_core.cli.arguments import FRAMES, VIEWS, changes, check_least, flag, option
from stereotrack_core.cli.output import say
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.study.description import StudySettings
from stereotrack_core.study.workers import ClusterWorkers, LocalWorkers

STUDY = option("study STUDY.study.toml", "study file", type=Path)
SELECT = option(
    "--select COLUMN=VALUE",
    "only recordings with this value, for example condition=slow; values are separated by commas, "
    "* stands for any letters; if given several times, all must agree",
    action="append",
    default=[],
)
SETTINGS = (
    option(
        "--preset accurate|thesis|fast|FILE.toml",
        "preset that the parameters come from (default: accurate), or a file with your own preset "
        "as saved by the workbench",
    ),
    changes("change one parameter"),
    option(
        "--grid NAME=a,b,c",
        "values of a parameter, or of views, preset, seed, frames, init or smooth; if given "
        "several times, all combinations are tried",
        action="append",
        default=[],
    ),
    option("--seeds 0,1,2", "comma-separated seeds (default: 0)"),
    FRAMES,
    VIEWS,
    option("--init auto|tpose|FILE", "initial pose, as for track (default: auto)"),
    flag("--smooth", "smooth the runs"),
)
RUNNING = (
    option("--workers N", "number of processes on this machine (default: one per core)", type=int),
    option(
        "--scheduler ADDRESS",
        "compute on a Dask cluster: tcp://host:port, tls://host:port, or a scheduler file (.json); "
        "all machines must see the recordings under the same path",
    ),
    flag("--again", "compute again what is there already"),
    flag("--dry-run", "only print what would be computed"),
)


def settings_of(args: Namespace, base: StudySettings | None = None) -> StudySettings:
    """The settings that options ask for, those of `base` for options that are not given.

    Raises InputError if they make no sense.
    """
    base = base or StudySettings()
    given: dict[str, Any] = {}
    for field in dataclasses.fields(StudySettings):
        value = getattr(args, field.name, None)
        if value:
            given[field.name] = tuple(value) if isinstance(value, list) else value
    settings = dataclasses.replace(base, **given)
    settings.check()
    return settings


def workers_of(args: Namespace) -> ClusterWorkers | LocalWorkers:
    """A cluster, or processes of this machine. Raises InputError for both at once."""
    check_least(1, workers=args.workers)
    if args.scheduler and args.workers is not None:
        raise InputError(
            "runs are computed on this machine or on a cluster",
            where="--workers, --scheduler",
            remedy="Use only one of them.",
        )
    return ClusterWorkers(args.scheduler) if args.scheduler else LocalWorkers(args.workers)


def say_findings(findings: Iterable[Finding]) -> None:
    """Say what a person should know."""
    for one in findings:
        say(f"{one.severity}: {one.where}: {one.what}. {one.remedy}".strip())
