"""Endpoints a server may listen on, checked before ZeroMQ sees them so that the message can be plain."""

import errno
import fcntl
import ipaddress
import os
import socket
import stat
import struct
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import zmq

from bridge.errors import BadInput

MAX_IPC_PATH = 107
"""Longest path of a Unix socket on Linux, in bytes."""
MOST_PORT = 65535
ROOT = 0  # the user who may do anything anyhow
BACKLOG = 128
"""Connections that wait to be accepted."""


@dataclass(frozen=True)
class CurveServer:
    """Keys of a server that speaks CURVE (Z85 text, 40 characters each).

    ``allowed`` holds the public keys of the clients that may connect; nobody else may.
    """

    public_key: str
    secret_key: str
    allowed: frozenset[str]


@dataclass(frozen=True)
class CurveClient:
    """Keys of a client that speaks CURVE (Z85 text), and the public key of its server."""

    public_key: str
    secret_key: str
    server_key: str

    def apply(self, sock: "zmq.Socket[bytes]") -> None:
        """Make ``sock`` use these keys; before it connects."""
        sock.curve_publickey = self.public_key.encode("ascii")
        sock.curve_secretkey = self.secret_key.encode("ascii")
        sock.curve_serverkey = self.server_key.encode("ascii")


def check_bindable(endpoint: str, curve: bool) -> None:
    """See to it that a server can listen on ``endpoint``; removes the socket file of a dead server.

    Raises
    ------
    BadInput
        Malformed, used by a live server, no such folder, or open to the network without CURVE.
    """
    scheme, separator, address = endpoint.partition("://")
    if not separator or not address or scheme not in ("ipc", "tcp"):
        raise BadInput(
            f"{endpoint!r} is not an endpoint.", "Use ipc:///path/to/socket or tcp://127.0.0.1:PORT."
        )
    if scheme == "ipc" and not address.startswith("@"):
        _check_ipc(endpoint, Path(address))
    elif scheme == "tcp":
        _check_tcp(endpoint, address, curve)


def _check_ipc(endpoint: str, path: Path) -> None:
    if len(os.fsencode(path)) > MAX_IPC_PATH:
        raise BadInput(
            f"The socket path of {endpoint} is longer than {MAX_IPC_PATH} bytes.", "Use a shorter folder."
        )
    if not path.parent.is_dir():
        raise BadInput(
            f"Cannot listen on {endpoint}: the folder {path.parent} does not exist.", "Create it first."
        )
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise BadInput(
            f"Cannot listen on {endpoint}: no permission to write in {path.parent}.", "Use another folder."
        )
    try:
        mode = path.lstat().st_mode
    except FileNotFoundError:
        return
    if not stat.S_ISSOCK(mode):
        raise BadInput(
            f"Cannot listen on {endpoint}: {path} exists and is not a socket.", "Use another name."
        )
    with socket.socket(socket.AF_UNIX) as probe:
        probe.settimeout(1.0)
        try:
            probe.connect(str(path))
        except (ConnectionRefusedError, FileNotFoundError):
            path.unlink(missing_ok=True)
            return
        except OSError:
            pass
    raise BadInput(
        f"Cannot listen on {endpoint}: another server is listening there.", "Stop it or use another name."
    )


def _check_tcp(endpoint: str, address: str, curve: bool) -> None:
    host, separator, port = address.rpartition(":")
    if not separator or not host or not (port == "*" or port.isdigit()):
        raise BadInput(f"{endpoint!r} names no host and port.", "Use tcp://127.0.0.1:PORT.")
    if port != "*" and int(port) > MOST_PORT:
        raise BadInput(f"{endpoint!r}: there is no port {port}.", f"Ports are 1 to {MOST_PORT}.")
    if not curve and not is_loopback(host):
        raise BadInput(
            f"Refusing to listen on {endpoint}: it can be reached from the network and has no CURVE keys.",
            "Use 127.0.0.1, or give the server keys: --keys DIR, made by python -m bridge keys DIR.",
        )


def is_loopback(host: str) -> bool:
    """Whether ``host`` can be reached from this machine only."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


def is_ipv6(endpoint: str) -> bool:
    """Whether ``endpoint`` names an IPv6 address, which ZeroMQ has to be told before it takes it."""
    return endpoint.startswith("tcp://") and endpoint.count(":") > 2  # the scheme's and the port's


def open_to_all(endpoint: str) -> bool:
    """Whether any user of the machine may connect where there are no keys: TCP does not tell who does."""
    return endpoint.startswith("tcp://")


def remove_ipc_file(endpoint: str) -> None:
    """Remove the socket file of an ipc endpoint that was bound here; ZeroMQ leaves it behind."""
    if endpoint.startswith("ipc://") and not endpoint.startswith("ipc://@"):
        with suppress(OSError):
            os.unlink(endpoint.removeprefix("ipc://"))


def same_user(connection: socket.socket) -> bool:
    """Whether who has connected is this process's user or root; TCP does not tell, so there all are."""
    if connection.family != socket.AF_UNIX:
        return True
    credentials = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize("3i"))
    return struct.unpack("3i", credentials)[1] in (ROOT, os.geteuid())


def bind(sock: "zmq.Socket[bytes]", endpoint: str) -> str:
    """Bind a socket with keys and return the endpoint as it was resolved (a port of ``*`` becomes a number).

    Raises
    ------
    BadInput
        As `check_bindable`, and when the port is in use or ZeroMQ refuses for another reason.
    """
    with _bindable(endpoint, curve=True):
        sock.ipv6 = is_ipv6(endpoint)
        try:
            sock.bind(endpoint)
        except zmq.ZMQError as error:
            raise _refused(endpoint, error) from error
    return sock.getsockopt_string(zmq.LAST_ENDPOINT)


def listen(endpoint: str) -> tuple[socket.socket, str]:
    """A listening socket for clients without keys, and the endpoint as it was resolved.

    Raises
    ------
    BadInput
        As `bind`.
    """
    with _bindable(endpoint, curve=False):
        scheme, _, address = endpoint.partition("://")
        listener = None
        try:
            if scheme == "ipc":
                listener = socket.socket(socket.AF_UNIX)
                listener.bind(f"\0{address[1:]}" if address.startswith("@") else address)
            else:
                host, _, port = address.rpartition(":")
                number = 0 if port == "*" else int(port)
                family, *_, place = socket.getaddrinfo(host.strip("[]"), number, type=socket.SOCK_STREAM)[0]
                listener = socket.create_server(place[:2], family=family)
                endpoint = f"tcp://{host}:{listener.getsockname()[1]}"
            listener.listen(BACKLOG)
        except OSError as error:
            if listener is not None:
                listener.close()
            raise _refused(endpoint, error) from error
    return listener, endpoint


@contextmanager
def _bindable(endpoint: str, curve: bool) -> Iterator[None]:
    """No other server takes the same socket file between the look at it and the binding."""
    folder = os.path.dirname(endpoint.removeprefix("ipc://")) if endpoint.startswith("ipc:///") else ""
    with ExitStack() as held:
        if os.path.isdir(folder):
            descriptor = os.open(folder, os.O_RDONLY)
            held.callback(os.close, descriptor)
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        check_bindable(endpoint, curve)
        yield


def _refused(endpoint: str, error: OSError | zmq.ZMQError) -> BadInput:
    if error.errno == errno.EADDRINUSE:
        return BadInput(
            f"Cannot listen on {endpoint}: the address is in use.", "Stop the other program or use another."
        )
    return BadInput(f"Cannot listen on {endpoint}: {error.strerror}.", "Check the endpoint's spelling.")
