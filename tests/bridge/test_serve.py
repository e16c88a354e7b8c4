import json
import select
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import zmq

from bridge.client import Client
from bridge.envelope import MAX_HEADER_BYTES
from bridge.errors import ServerError
from bridge.messages import NoArgs
from bridge.serve import Reply, Server

from .conftest import Counter, Running, wait_until

SETTINGS = {"lights": [1, 2, 3], "shutter_s": 0.01, "aperture": 4.0}


class Raw:
    """A bare socket that says what it likes."""

    def __init__(self, endpoint: str, kind: int = zmq.DEALER) -> None:
        self.context: Any = zmq.Context()
        self.socket = self.context.socket(kind)
        self.socket.linger = 0
        self.socket.connect(endpoint)

    def ask(self, *frames: bytes) -> dict[str, Any]:
        self.socket.send_multipart(frames)
        assert self.socket.poll(60_000), "no reply"
        answer = self.socket.recv_multipart()
        return dict(json.loads(answer[-1]))


@pytest.fixture
def raw(counter: Running) -> Iterator[Raw]:
    """A bare socket connected to the counter."""
    bare = Raw(counter.endpoint)
    yield bare
    bare.context.destroy(linger=0)


def request(op: str = "count", number: int = 1, **changes: Any) -> bytes:
    return json.dumps({"v": 1, "id": f"raw/{number}", "op": op, "args": {}, **changes}).encode()


@pytest.mark.parametrize(
    ("frames", "code", "request_id"),
    [
        ([b""], "bad_message", None),
        ([b"", b""], "bad_message", None),
        ([b"\xff\xfe"], "bad_message", None),
        ([b"{"], "bad_message", None),
        ([b"[]"], "bad_message", None),
        ([b"[" * 50_000], "bad_message", None),
        ([b'{"v":1,"id":' + b'{"a":' * 50_000], "bad_message", None),
        ([b'{"v":' + b"9" * 1_000_000 + b"}"], "bad_message", None),
        ([b'{"v":1,"id":"a/1\\n","op":"hello","args":{}}'], "bad_message", "a/1\n"),
        ([b'{"v":1}'], "bad_message", None),
        ([request(v=2)], "bad_version", "raw/1"),
        ([request(v=2, colour="red")], "bad_version", "raw/1"),
        ([request(v="1")], "bad_message", None),
        ([request(id="no-number")], "bad_message", "no-number"),
        ([request(extra=1)], "bad_message", "raw/1"),
        ([request(op="dance")], "unknown_operation", "raw/1"),
        ([request(op=7)], "bad_message", "raw/1"),
        ([request(args=[])], "bad_arguments", "raw/1"),
        ([request(args={"x": 1})], "bad_arguments", "raw/1"),
        ([request("capture", args={"settings": {**SETTINGS, "lights": [-1]}})], "bad_arguments", "raw/1"),
        ([b'{"v":1,"id":"raw/1","op":"echo","args":{"x":NaN}}'], "bad_message", None),
        ([b'{"v":1,"id":"raw/1","op":"echo","args":{"x":1e999}}'], "bad_arguments", "raw/1"),
        ([request(), b"pixels"], "bad_frames", "raw/1"),
        ([b"x" * (MAX_HEADER_BYTES + 1)], "too_large", None),
    ],
)
def test_whatever_breaks_the_protocol_gets_an_error_reply(
    counter: Running, raw: Raw, frames: list[bytes], code: str, request_id: str | None
) -> None:
    reply = raw.ask(*frames)
    assert (reply["ok"], reply["error"]["code"], reply["id"]) == (False, code, request_id)
    assert reply["error"]["message"].endswith(".")
    assert counter.service.count == 0
    assert raw.ask(request(number=2))["result"] == {"count": 1}


def test_a_frame_beyond_all_bounds_ends_only_its_connection(counter: Running, raw: Raw) -> None:
    raw.socket.send(bytes(70 * 1024 * 1024))
    with Client(counter.endpoint) as client:
        assert client.request("count")[0] == {"count": 1}


def test_an_error_reply_names_the_field_and_lists_the_others(raw: Raw) -> None:
    error = raw.ask(request("capture", args={"settings": {**SETTINGS, "aperture": 0}}))["error"]
    assert "$.settings.aperture" in error["message"]
    assert "'capture' of the counter" in error["message"]
    assert "settings" in error["hint"]


def test_a_repeated_request_is_answered_and_not_done_twice(counter: Running, raw: Raw) -> None:
    first = raw.ask(request())
    assert raw.ask(request()) == first
    other = Raw(counter.endpoint)
    assert other.ask(request()) == first
    other.context.destroy(linger=0)
    assert counter.service.count == 1


def test_a_repeated_error_is_the_same_error(raw: Raw) -> None:
    assert raw.ask(request("jam")) == raw.ask(request("jam"))


def test_an_id_is_not_used_for_two_things(counter: Running, raw: Raw) -> None:
    raw.ask(request())
    assert raw.ask(request("jam"))["error"]["code"] == "id_reused"
    assert counter.service.count == 1


def test_a_req_socket_can_ask_too(counter: Running) -> None:
    bare = Raw(counter.endpoint, zmq.REQ)
    assert bare.ask(request())["result"] == {"count": 1}
    bare.context.destroy(linger=0)


@pytest.mark.parametrize(
    ("op", "code", "said"),
    [
        ("refuse", "bad_input", "The file é is missing."),
        ("jam", "device_error", "The shutter is stuck."),
        ("fail", "internal", "KeyError: 'surprise' (conftest.py, line"),
        ("not_finite", "internal", "result.a[1] is nan"),
        ("huge", "internal", "more than"),
        ("sort", "internal", "cannot be sent"),
    ],
)
def test_a_handler_that_fails_ends_nothing(counter: Running, op: str, code: str, said: str) -> None:
    with Client(counter.endpoint) as client:
        with pytest.raises(ServerError) as caught:
            client.request(op)
        assert caught.value.code == code
        assert said in caught.value.message
        assert client.request("count")[0] == {"count": 1}


def test_a_handler_gets_typed_arguments_and_returns_arrays(counter: Running) -> None:
    with Client(counter.endpoint) as client:
        result, arrays = client.request("capture", {"settings": SETTINGS})
    assert result["settings"] == {**SETTINGS, "focal_length_mm": None, "focus_m": None}
    assert [(a.dtype.name, a.shape) for a in arrays] == [("uint8", (3, 4)), ("float32", (4, 3))]
    assert arrays[0].tolist() == [[0, 1, 2, 3], [4, 5, 6, 7], [8, 9, 10, 11]]
    assert arrays[1].tolist() == arrays[0].T.tolist()


def test_numpy_values_become_json(counter: Running) -> None:
    with Client(counter.endpoint) as client:
        assert client.request("numpy")[0] == {"a": 0.5, "b": [0, 1, 2]}


def test_every_server_says_who_it_is_and_how_it_is(counter: Running) -> None:
    with Client(counter.endpoint) as client:
        hello = client.request("hello")[0]
        assert (hello["server"], hello["protocol"]) == ("counter", 1)
        assert {"hello", "health", "shutdown", "count"} <= set(hello["operations"])
        health = client.request("health")[0]
        assert (health["status"], health["requests"]) == ("ok", 2)


def test_shutdown_is_answered_and_ends_the_loop(counter: Running, folder: Path) -> None:
    with Client(counter.endpoint) as client:
        assert client.request("shutdown")[0] == {}
    counter.thread.join(60)
    assert counter.status == 0
    assert counter.service.closed == 1


def test_a_reply_that_is_ready_while_another_is_sent_leaves_at_once(folder: Path) -> None:
    class Late(Server):
        """Its `hello` is answered when the work that waits is done, and has woken the loop."""

        def _hello(self, args: NoArgs) -> Reply:
            service.released.set()
            assert select.select([self._sockets.wake_fileno], [], [], 60)[0]
            return super()._hello(args)

    service = Counter()
    running = Running(service, Late(service, f"ipc://{folder}/s"))
    waiting, asking = Raw(running.endpoint), Raw(running.endpoint)
    try:
        waiting.socket.send(request("wait"))
        assert wait_until(lambda: service.count == 1)
        assert asking.ask(request("hello", 2))["ok"]
        assert waiting.socket.poll(60_000), "the reply waits for somebody's next request"
    finally:
        for bare in (waiting, asking):
            bare.context.destroy(linger=0)
        running.stop()


def test_many_clients_at_once(counter: Running) -> None:
    def ask() -> None:
        with Client(counter.endpoint) as client:
            for _ in range(50):
                client.request("count")

    threads = [threading.Thread(target=ask) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert counter.service.count == 300


class TestEvents:
    def test_events_arrive_in_order_after_a_welcome(self, counter: Running, folder: Path) -> None:
        with zmq.Context() as context, context.socket(zmq.SUB) as sub:
            sub.linger = 0
            sub.subscribe(b"")
            sub.connect(f"ipc://{folder}/e")
            assert sub.poll(60_000)
            assert sub.recv_json()["event"] == "welcome"
            with Client(counter.endpoint) as client:
                for _ in range(3):
                    client.request("count")
            counter.service.emit("camera_fault", {"from": "another thread"})
            events = [sub.recv_json() for _ in range(4) if sub.poll(60_000)]
        assert [event["sequence"] for event in events] == [1, 2, 3, 4]
        assert events[2] == {"v": 1, "event": "sun_changed", "args": {"count": 3}, "sequence": 3}
        assert events[3]["event"] == "camera_fault"

    def test_who_subscribes_is_welcomed_alone_and_misses_nothing_from_then_on(
        self, counter: Running, folder: Path
    ) -> None:
        with zmq.Context() as context, context.socket(zmq.SUB) as first, context.socket(zmq.SUB) as late:
            first.linger = late.linger = 0
            first.subscribe(b"")
            for sub in (first, late):
                sub.connect(f"ipc://{folder}/e")
            assert first.poll(60_000)
            assert first.recv_json()["event"] == "welcome"
            counter.service.emit("sun_changed", {})
            assert first.poll(60_000)
            assert first.recv_json()["sequence"] == 1
            assert not late.poll(200)  # connected, and not subscribed yet
            late.subscribe(b"")
            assert late.poll(60_000)
            assert late.recv_json()["event"] == "welcome"
            counter.service.emit("camera_fault", {})
            for sub in (first, late):
                assert sub.poll(60_000)
                assert sub.recv_json() == {"v": 1, "event": "camera_fault", "args": {}, "sequence": 2}

    def test_topics_are_subscribed_to_and_left(self, counter: Running, folder: Path) -> None:
        with zmq.Context() as context, context.socket(zmq.SUB) as sub:
            sub.linger = 0
            faults = b'{"v":1,"event":"camera_fault"'
            for topic in (b'{"', faults):
                sub.subscribe(topic)
            sub.connect(f"ipc://{folder}/e")
            assert sub.poll(60_000)
            assert sub.recv_json()["event"] == "welcome"
            sub.unsubscribe(b'{"')
            while counter.service.emit("sun_changed", {}) < 1000 and sub.poll(10):
                assert sub.recv_json()["event"] in {"welcome", "sun_changed"}
            counter.service.emit("camera_fault", {})
            assert sub.poll(60_000)
            assert sub.recv_json()["event"] == "camera_fault"

    def test_without_an_endpoint_nothing_is_published(self, folder: Path) -> None:
        service = Counter()
        running = Running(service, Server(service, f"ipc://{folder}/s"))
        assert service.emit("sun_changed") == 0
        assert service.events_endpoint is None
        running.stop()

    def test_after_the_end_nothing_is_published(self, counter: Running) -> None:
        counter.stop()
        assert counter.service.emit("sun_changed") == 0

    def test_a_free_port_is_found_and_told(self) -> None:
        service = Counter()
        running = Running(service, Server(service, "tcp://127.0.0.1:*", events="tcp://127.0.0.1:*"))
        assert service.events_endpoint is not None
        assert not service.events_endpoint.endswith("*")
        with Client(running.endpoint) as client:
            assert client.request("count")[0] == {"count": 1}
        running.stop()
        assert wait_until(lambda: running.status == 0)
