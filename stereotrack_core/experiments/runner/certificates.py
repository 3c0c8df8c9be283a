"""Certificates by which a Dask cluster and its client know each other, over TLS."""

from __future__ import annotations

import ssl
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stereotrack_core.errors import InputError

_OPTIONS = "--tls-ca, --tls-cert, --tls-key"


class _HasPassword(Exception):
    """The key cannot be read without one."""


@dataclass(frozen=True)
class Certificates:
    """Files in PEM: the authority that has signed all certificates, the client's own, and its key.

    Raises InputError where they cannot be read or do not belong together.
    """

    ca: Path
    cert: Path
    key: Path

    def __post_init__(self) -> None:
        for option, path in (("ca", self.ca), ("cert", self.cert), ("key", self.key)):
            if not path.is_file():
                raise InputError(
                    "there is no such file",
                    where=f"--tls-{option} {path}",
                    remedy="Give a file in PEM, as the administrator of the cluster has made it.",
                )
        try:
            context = ssl.create_default_context(cafile=str(self.ca))
        except (ssl.SSLError, OSError) as error:
            raise _unusable("this is no certificate of an authority", "ca", self.ca) from error
        try:
            context.load_cert_chain(self.cert, self.key, password=_refuse)
        except _HasPassword:
            raise InputError(
                "the key has a password, which Dask cannot be given",
                where=f"--tls-key {self.key}",
                remedy="Give a key without a password that only you can read.",
            ) from None
        except (ssl.SSLError, OSError) as error:
            what = "the certificate and the key cannot be read, or do not belong together"
            raise _unusable(what, "cert", self.cert) from error

    def security(self, distributed: Any) -> Any:
        """The same as Dask takes it; an unencrypted connection is refused."""
        return distributed.Security(
            tls_ca_file=str(self.ca),
            tls_client_cert=str(self.cert),
            tls_client_key=str(self.key),
            require_encryption=True,
        )


def _refuse() -> str:
    raise _HasPassword


def _unusable(what: str, option: str, path: Path) -> InputError:
    return InputError(
        what, where=f"--tls-{option} {path}", remedy="Give the files in PEM that belong together."
    )


def certificates_of(
    scheduler: str | None, ca: Path | None, cert: Path | None, key: Path | None
) -> Certificates | None:
    """The certificates that are given for a scheduler; None where none are.

    Raises InputError where some are missing, cannot be used, or the address is not encrypted.
    """
    given = (ca, cert, key)
    if not any(given):
        return None
    if ca is None or cert is None or key is None:
        raise InputError(
            "a certificate is missing",
            where=_OPTIONS,
            remedy="Give all three files: of the authority, the certificate and its key.",
        )
    if not scheduler:
        raise InputError(
            "certificates are for a Dask cluster",
            where=_OPTIONS,
            remedy="Give its address with --scheduler, or omit them.",
        )
    if not scheduler.startswith("tls://") and not scheduler.endswith(".json"):
        raise InputError(
            "this address is not encrypted",
            where=f"--scheduler {scheduler}",
            remedy="Start the scheduler with `dask scheduler --protocol tls`, and give its address "
            "tls://HOST:PORT.",
        )
    return Certificates(ca, cert, key)
