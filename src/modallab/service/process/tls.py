"""TLS: the certificate of the service, as named or made here, and what its listeners need of it."""

import os
import ssl
from collections.abc import Iterable
from datetime import UTC, datetime, timedelta
from ipaddress import ip_address
from pathlib import Path
from typing import TYPE_CHECKING

from modallab.core.discovery import require_package
from modallab.core.settings import LOOPBACK, Settings
from modallab.service.errors import ServiceError

if TYPE_CHECKING:
    from cryptography.x509 import Certificate, GeneralName

FOLDER = "tls"
LIFE = timedelta(days=825)
LEFT = timedelta(days=30)
"""A certificate that was made here is made again when less is left of it."""


def configure_tls(settings: Settings) -> Settings:
    """The settings with certificate and key, which are made if that was asked for; as they were, if TLS was not.

    Raises:
        ServiceError: only one of the two files is named, one is to be made besides, or they cannot be used.
    """
    cert, key = settings.tls_cert, settings.tls_key
    if settings.tls_self_signed:
        if cert or key:
            raise _certificate_error("a certificate is named, and another was requested", "name one, or request one")
        cert, key = self_signed(settings.data / FOLDER, {*LOOPBACK, settings.host, *settings.hosts})
        settings = settings.model_copy(update={"tls_cert": cert, "tls_key": key})
    elif (cert is None) != (key is None):
        raise _certificate_error("TLS needs a certificate and its key", "give --tls-cert and --tls-key")
    server_context(settings)
    return settings


def server_context(settings: Settings) -> ssl.SSLContext | None:
    """What a listener needs to speak TLS; None if it is to speak plain HTTP.

    Raises:
        ServiceError: certificate and key cannot be used.
    """
    if settings.tls_cert is None or settings.tls_key is None:
        return None
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    try:
        context.load_cert_chain(settings.tls_cert, settings.tls_key)
    except OSError as error:
        raise _certificate_error(
            f"{settings.tls_cert} and {settings.tls_key} cannot be used: {error}",
            "give a certificate and its key, both as PEM",
        ) from error
    return context


def self_signed(folder: Path, names: Iterable[str]) -> tuple[Path, Path]:
    """Certificate and key for these names, as PEM files in a folder; made again if they end soon or lack a name.

    Raises:
        MissingPackageError: the package that makes certificates is not installed.
        ServiceError: they cannot be written.
    """
    require_package("cryptography", "making a certificate")
    cert, key, names = folder / "cert.pem", folder / "key.pem", frozenset(names)
    if not _certificate_is_good(cert, key, names):
        try:
            folder.mkdir(parents=True, exist_ok=True)
            _make_certificate(cert, key, names)
        except OSError as error:
            raise _certificate_error(f"{folder} cannot be written: {error.strerror}", "look at the disk") from error
    return cert, key


def certificate_fingerprint(cert: Path) -> str:
    """SHA-256 of a certificate, by which people compare what a browser shows."""
    import hashlib

    digest = hashlib.sha256(ssl.PEM_cert_to_DER_cert(cert.read_text(encoding="ascii").strip())).hexdigest().upper()
    return ":".join(digest[i : i + 2] for i in range(0, len(digest), 2))


def _certificate_is_good(cert: Path, key: Path, names: frozenset[str]) -> bool:
    from cryptography import x509

    try:
        found: Certificate = x509.load_pem_x509_certificate(cert.read_bytes())
        for_names = found.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except (OSError, ValueError, x509.ExtensionNotFound):
        return False
    return (
        key.exists()
        and found.not_valid_after_utc - datetime.now(UTC) > LEFT
        and set(_general_names(names)) <= set(for_names)
    )


def _make_certificate(cert: Path, key: Path, names: frozenset[str]) -> None:
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import ec
    from cryptography.x509.oid import NameOID

    secret = ec.generate_private_key(ec.SECP256R1())
    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "modallab")])
    # A clock that is behind by some hours must not make it a certificate of the future.
    begin = datetime.now(UTC) - timedelta(days=1)
    made = (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(subject)
        .public_key(secret.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(begin)
        .not_valid_after(begin + LIFE)
        .add_extension(x509.SubjectAlternativeName(_general_names(names)), critical=False)
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .sign(secret, hashes.SHA256())
    )
    encoding, plain = serialization.Encoding.PEM, serialization.NoEncryption()
    key.unlink(missing_ok=True)
    with os.fdopen(os.open(key, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
        file.write(secret.private_bytes(encoding, serialization.PrivateFormat.PKCS8, plain))
    cert.write_bytes(made.public_bytes(encoding))


def _general_names(names: Iterable[str]) -> "list[GeneralName]":
    from cryptography import x509

    found: list[GeneralName] = []
    for name in sorted(names):
        try:
            found.append(x509.IPAddress(ip_address(name)))
        except ValueError:
            found.append(x509.DNSName(name.encode("idna").decode()))
    return found


def _certificate_error(what: str, remedy: str) -> ServiceError:
    return ServiceError(what, where="tls", remedy=remedy)
