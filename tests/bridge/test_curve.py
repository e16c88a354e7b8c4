import itertools
import socket
import threading
import time
from contextlib import suppress
from pathlib import Path

import pytest
import zmq

from bridge.client import Client
from bridge.endpoints import CurveClient, CurveServer
from bridge.errors import BridgeRefused, BridgeTimeout, LightsAndCameraError
from bridge.serve import Server

from .conftest import Counter, Running


def keys() -> tuple[str, str]:
    public, secret = zmq.curve_keypair()
    return public.decode(), secret.decode()


def test_only_clients_with_a_known_key_get_in() -> None:
    server_public, server_secret = keys()
    public, secret = keys()
    strange_public, strange_secret = keys()
    service = Counter()
    curve = CurveServer(server_public, server_secret, frozenset({public}))
    running = Running(service, Server(service, "tcp://127.0.0.1:*", curve=curve))
    try:
        with Client(
            running.endpoint, timeout_s=60, curve=CurveClient(public, secret, server_public)
        ) as client:
            assert client.request("count")[0] == {"count": 1}
        strangers = [
            CurveClient(strange_public, strange_secret, server_public),
            CurveClient(public, secret, strange_public),
            None,
        ]
        for stranger, refused_first in itertools.product(strangers, (False, True)):
            client = Client(running.endpoint, timeout_s=0.5, retries=20, curve=stranger)
            if refused_first:  # then there is no way left to send on, and that must not block
                client._connected()
                time.sleep(0.2)
            with client, pytest.raises(BridgeRefused, match=r"does not let this client in.*--keys"):
                client.request("count")
        assert service.count == 1
    finally:
        running.stop()


@pytest.mark.parametrize("with_keys", [False, True])
def test_an_ipv6_address_can_be_reached(with_keys: bool) -> None:
    try:
        socket.create_server(("::1", 0), family=socket.AF_INET6).close()
    except OSError:
        pytest.skip("there is no IPv6 here")
    server, client = keys(), keys()
    curve = CurveServer(*server, frozenset({client[0]})) if with_keys else None
    running = Running(Counter(), Server(Counter(), "tcp://[::1]:*", events="tcp://[::1]:*", curve=curve))
    try:
        own = CurveClient(*client, server[0]) if with_keys else None
        with Client(running.endpoint, timeout_s=60, curve=own) as connected:
            assert connected.request("count")[0] == {"count": 1}
    finally:
        running.stop()


def test_a_client_without_keys_is_not_told_that_nobody_is_there() -> None:
    server_public, server_secret = keys()
    curve = CurveServer(server_public, server_secret, frozenset({keys()[0]}))
    service = Counter()
    running = Running(service, Server(service, "tcp://127.0.0.1:*", curve=curve))
    strangers = [None, CurveClient(*keys(), server_public), CurveClient(*keys(), keys()[0])]
    try:
        for stranger in strangers:
            with (
                Client(running.endpoint, timeout_s=6.0, curve=stranger, absent_s=0.5) as client,
                pytest.raises(BridgeRefused),
            ):
                client.request("count")
    finally:
        running.stop()


def test_a_way_that_is_lost_before_the_message_leaves_is_no_wait_for_ever(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    server_public, server_secret = keys()
    service = Counter()
    curve = CurveServer(server_public, server_secret, frozenset({keys()[0]}))
    running = Running(service, Server(service, "tcp://127.0.0.1:*", curve=curve))
    stranger = CurveClient(*keys(), server_public)
    client = Client(running.endpoint, timeout_s=0.5, retries=1, curve=stranger)
    told: list[int] = []
    ready = client._ready

    def once_too_often(sock: zmq.Socket[bytes], event: int, deadline: float) -> bool:
        if told:
            return ready(sock, event, deadline)
        told.append(event)
        while sock.poll(0, event):  # until the server hangs up
            time.sleep(0.01)
        return True

    def ask() -> None:
        with suppress(LightsAndCameraError):
            client.request("count")

    monkeypatch.setattr(client, "_ready", once_too_often)
    asking = threading.Thread(target=ask, daemon=True)
    try:
        asking.start()
        asking.join(30.0)
        assert not asking.is_alive()
        assert told == [zmq.POLLOUT]
    finally:
        running.stop()


def test_one_with_keys_is_refused_where_there_are_none_and_one_that_stands_still_is_waited_for() -> None:
    public, secret = keys()
    service = Counter()
    running = Running(service, Server(service, "tcp://127.0.0.1:*"))
    try:
        curve = CurveClient(public, secret, keys()[0])
        client = Client(running.endpoint, timeout_s=0.5, retries=20, curve=curve)
        with client, pytest.raises(BridgeRefused):
            client.request("count")
    finally:
        running.stop()
    with socket.socket() as silent:  # listens, and says nothing
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        endpoint = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        with Client(endpoint, timeout_s=0.5) as client, pytest.raises(BridgeTimeout):
            client.request("count")


def test_events_want_the_key_too(folder: Path) -> None:
    server_public, server_secret = keys()
    public, secret = keys()
    service = Counter()
    curve = CurveServer(server_public, server_secret, frozenset({public}))
    running = Running(service, Server(service, f"ipc://{folder}/s", events=f"ipc://{folder}/e", curve=curve))
    try:
        with zmq.Context() as context, context.socket(zmq.SUB) as known, context.socket(zmq.SUB) as stranger:
            CurveClient(public, secret, server_public).apply(known)
            for sub in (known, stranger):
                sub.linger = 0
                sub.subscribe(b"")
                sub.connect(f"ipc://{folder}/e")
            assert known.poll(60_000)
            assert known.recv_json()["event"] == "welcome"
            assert not stranger.poll(200)
    finally:
        running.stop()
