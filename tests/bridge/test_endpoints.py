import socket
from pathlib import Path

import pytest
import zmq

from bridge.endpoints import check_bindable, is_loopback
from bridge.errors import BadInput
from bridge.serve import Server

from .conftest import Counter


@pytest.mark.parametrize(
    ("endpoint", "complaint"),
    [
        ("nonsense", "is not an endpoint"),
        ("udp://127.0.0.1:5", "is not an endpoint"),
        ("ipc://", "is not an endpoint"),
        ("ipc:///no/such/folder/s", "does not exist"),
        ("ipc:///tmp/" + "x" * 120, "longer than 107 bytes"),
        ("tcp://5555", "names no host and port"),
        ("tcp://127.0.0.1:99999", "there is no port 99999"),
        ("tcp://0.0.0.0:5555", "reached from the network"),
        ("tcp://*:5555", "reached from the network"),
        ("tcp://192.168.1.1:5555", "reached from the network"),
    ],
)
def test_an_endpoint_that_cannot_be_used_is_explained(endpoint: str, complaint: str) -> None:
    with pytest.raises(BadInput, match=complaint):
        check_bindable(endpoint, curve=False)


def test_with_keys_the_network_may_come_in() -> None:
    check_bindable("tcp://0.0.0.0:5555", curve=True)


def test_loopback() -> None:
    assert is_loopback("localhost")
    assert is_loopback("127.1.2.3")
    assert is_loopback("[::1]")
    assert not is_loopback("example.org")


def test_the_socket_file_of_a_dead_server_is_removed(folder: Path) -> None:
    path = folder / "s"
    dead = socket.socket(socket.AF_UNIX)
    dead.bind(str(path))
    dead.close()
    assert path.exists()
    check_bindable(f"ipc://{path}", curve=False)
    assert not path.exists()


def test_a_live_server_is_left_alone(folder: Path) -> None:
    path = folder / "s"
    with socket.socket(socket.AF_UNIX) as live:
        live.bind(str(path))
        live.listen()
        with pytest.raises(BadInput, match="another server is listening"):
            check_bindable(f"ipc://{path}", curve=False)
    assert path.exists()


def test_another_file_is_left_alone(folder: Path) -> None:
    path = folder / "s"
    path.write_text("precious")
    with pytest.raises(BadInput, match="is not a socket"):
        check_bindable(f"ipc://{path}", curve=False)
    assert path.read_text() == "precious"


def test_a_port_in_use_is_explained_and_the_service_closed() -> None:
    with zmq.Context() as context, context.socket(zmq.ROUTER) as taken:
        port = taken.bind_to_random_port("tcp://127.0.0.1")
        service = Counter()
        with pytest.raises(BadInput, match="in use"):
            Server(service, f"tcp://127.0.0.1:{port}")
        assert service.closed == 1


def test_a_stopped_server_leaves_no_socket_file(counter, folder: Path) -> None:  # type: ignore[no-untyped-def]
    assert {path.name for path in folder.iterdir()} == {"s", "e"}
    counter.stop()
    assert list(folder.iterdir()) == []
    assert counter.service.closed == 1
