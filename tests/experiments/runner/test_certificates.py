"""Certificates for a Dask cluster: which are refused, and whom an encrypted one lets in."""

import json
import shutil
import subprocess

import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.experiments.runner.certificates import Certificates, certificates_of
from stereotrack_core.experiments.runner.cluster import ClusterWorkers
from tests.experiments.runner.dask_cluster import DaskCluster

pytestmark = pytest.mark.skipif(shutil.which("openssl") is None, reason="openssl makes them")


def openssl(folder, *words):
    subprocess.run(["openssl", *words], cwd=folder, check=True, capture_output=True)


def made_in(folder):
    """An authority and a certificate that it has signed; also a key with a password."""
    key = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes")
    openssl(folder, *("req", "-x509", *key, "-keyout", "ca.key", "-out", "ca.pem"),
            *("-subj", "/CN=authority", "-days", "2"))  # fmt: skip
    openssl(folder, *("req", *key, "-keyout", "key.pem", "-out", "request.pem"),
            *("-subj", "/CN=cluster"))  # fmt: skip
    openssl(folder, *("x509", "-req", "-in", "request.pem", "-CA", "ca.pem", "-CAkey", "ca.key"),
            *("-CAcreateserial", "-out", "cert.pem", "-days", "2"))  # fmt: skip
    openssl(folder, *("ec", "-in", "key.pem", "-aes128", "-passout", "pass:secret"),
            *("-out", "locked.pem"))  # fmt: skip
    return folder


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    return made_in(tmp_path_factory.mktemp("certificates"))


@pytest.mark.parametrize(
    ("ca", "cert", "key", "words"),
    [
        ("none.pem", "cert.pem", "key.pem", "--tls-ca .*none.pem: there is no such file"),
        ("request.pem", "cert.pem", "key.pem", "--tls-ca .*no certificate of an authority"),
        ("ca.pem", "cert.pem", "ca.key", "--tls-cert .*do not belong together"),
        ("ca.pem", "cert.pem", "locked.pem", "--tls-key .*the key has a password"),
    ],
)
def test_files_that_cannot_be_used_are_refused(files, ca, cert, key, words):
    with pytest.raises(InputError, match=words):
        Certificates(files / ca, files / cert, files / key)


def test_what_does_not_go_together_is_refused(files):
    ca, cert, key = (files / name for name in ("ca.pem", "cert.pem", "key.pem"))
    assert certificates_of("tcp://a:1", None, None, None) is None
    for address in ("tls://a:1", "scheduler.json"):
        assert certificates_of(address, ca, cert, key) == Certificates(ca, cert, key)
    with pytest.raises(InputError, match="Give all three files"):
        certificates_of("tls://a:1", ca, cert, None)
    with pytest.raises(InputError, match="--scheduler"):
        certificates_of(None, ca, cert, key)
    with pytest.raises(InputError, match=r"not encrypted.*--protocol tls"):
        certificates_of("tcp://a:1", ca, cert, key)


@pytest.mark.slow
def test_only_a_client_with_a_certificate_of_the_authority_is_let_in(files, tmp_path):
    own = Certificates(*(files / name for name in ("ca.pem", "cert.pem", "key.pem")))
    words = ("--tls-ca-file", own.ca, "--tls-cert", own.cert, "--tls-key", own.key)
    running = DaskCluster(tmp_path, 0, "--protocol", "tls", *map(str, words))
    try:
        address = json.loads(running.file.read_text())["address"]
        assert address.startswith("tls://")
        for given in (address, str(running.file)):
            with ClusterWorkers(given, certificates=own) as cluster:
                assert cluster.count == 0
        with pytest.raises(InputError, match=r"needs certificates.*--tls-ca"):
            ClusterWorkers(address, patience=0.5)
        folder = made_in(tmp_path)
        others = Certificates(*(folder / name for name in ("ca.pem", "cert.pem", "key.pem")))
        for foreign in (others, Certificates(own.ca, others.cert, others.key)):
            with pytest.raises(InputError, match="does not accept the certificates"):
                ClusterWorkers(address, certificates=foreign, patience=0.5)
        plain = address.replace("tls://", "tcp://")
        with pytest.raises(InputError, match="no scheduler answers"):
            ClusterWorkers(plain, patience=0.5)
    finally:
        running.close()
