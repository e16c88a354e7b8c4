import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
import zmq

from bridge.client import Client
from bridge.errors import BadInput, BridgeTimeout, LightsAndCameraError, ProtocolError, ServerError

from .conftest import Running


def test_a_request_is_done_once_however_often_it_is_sent(counter: Running) -> None:
    threading.Timer(1.0, counter.service.released.set).start()
    with Client(counter.endpoint, timeout_s=60.0, retries=239) as client:  # one attempt each 0.25 s
        assert client.request("wait")[0] == {"count": 1}
    assert counter.service.count == 1


def test_no_answer_is_a_timeout_that_says_so(counter: Running) -> None:
    with Client(counter.endpoint, timeout_s=0.2, retries=1) as client:
        with pytest.raises(BridgeTimeout) as caught:
            client.request("wait")
        assert (caught.value.endpoint, caught.value.op) == (counter.endpoint, "wait")
        counter.service.released.set()
        assert client.request("count", timeout_s=60)[0]["count"] == counter.service.count


def test_nobody_there_is_a_timeout(folder: Path) -> None:
    with Client(f"ipc://{folder}/nobody", timeout_s=0.1) as client, pytest.raises(BridgeTimeout):
        client.request("hello")


def test_a_server_that_starts_late_is_found(folder: Path, counter: Running) -> None:
    counter.stop()
    with Client(counter.endpoint, timeout_s=60.0) as client:
        answers: list[dict[str, object]] = []
        asking = threading.Thread(target=lambda: answers.append(client.request("count")[0]))
        asking.start()
        from bridge.serve import Server

        from .conftest import Counter

        service = Counter()
        late = Running(service, Server(service, counter.endpoint))
        asking.join()
        assert answers == [{"count": 1}]
        late.stop()


def test_a_malformed_endpoint_is_bad_input() -> None:
    with Client("nonsense") as client, pytest.raises(BadInput, match="nonsense"):
        client.request("hello")


@pytest.mark.parametrize("bad", [float("nan"), float("inf")])
def test_numbers_that_are_not_finite_are_not_sent(counter: Running, bad: float) -> None:
    with Client(counter.endpoint) as client, pytest.raises(ValueError, match=r"args\.x"):
        client.request("echo", {"x": bad})


class Impostor:
    """Answers whatever it is told to."""

    def __init__(self, endpoint: str, *replies: list[bytes]) -> None:
        self.context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self.socket = self.context.socket(zmq.ROUTER)
        self.socket.linger = 0
        self.socket.bind(endpoint)
        self.replies = replies
        self.thread = threading.Thread(target=self._run)
        self.thread.start()

    def _run(self) -> None:
        self.socket.poll(60_000)
        route, header = self.socket.recv_multipart()
        request_id = header.split(b'"id":"')[1].split(b'"')[0]
        for reply in self.replies:
            self.socket.send_multipart([route, *(frame.replace(b"ID", request_id) for frame in reply)])

    def stop(self) -> None:
        self.thread.join()
        self.context.destroy(linger=0)


GOOD = b'{"v":1,"id":"ID","ok":true,"result":{"a":1}}'


@pytest.mark.parametrize(
    ("replies", "error", "said"),
    [
        ([[b"garbage"]], ProtocolError, "cannot be read"),
        ([[b'{"v":7,"id":"ID","ok":true,"result":{}}']], ProtocolError, "version 7"),
        (
            [[b'{"v":1,"id":"ID","ok":true,"result":{},"arrays":[{"dtype":"uint8","shape":[9]}]}', b"x"]],
            ProtocolError,
            "should have 9 bytes",
        ),
        (
            [[b'{"v":1,"id":null,"ok":false,"error":{"code":"bad_message","message":"What?"}}']],
            ServerError,
            "What?",
        ),
    ],
)
def test_a_reply_that_is_none_is_an_error(
    folder: Path, replies: list[list[bytes]], error: type[LightsAndCameraError], said: str
) -> None:
    impostor = Impostor(f"ipc://{folder}/i", *replies)
    with Client(f"ipc://{folder}/i", timeout_s=60) as client, pytest.raises(error, match=said):
        client.request("hello")
    impostor.stop()


def test_replies_to_other_requests_are_dropped(folder: Path) -> None:
    stale = b'{"v":1,"id":"somebody/1","ok":true,"result":{"a":2}}'
    stale_error = b'{"v":1,"id":"somebody/2","ok":false,"error":{"code":"x","message":"m"}}'
    impostor = Impostor(f"ipc://{folder}/i", [stale], [stale_error], [GOOD])
    with Client(f"ipc://{folder}/i", timeout_s=60) as client:
        assert client.request("hello")[0] == {"a": 1}
    impostor.stop()


def test_a_client_can_be_closed_while_requests_are_lost(counter: Running) -> None:
    client = Client(counter.endpoint, timeout_s=1.0, retries=0)
    with pytest.raises(BridgeTimeout):
        client.request("wait")
    assert counter.service.count == 1  # it has arrived
    client.close()
    counter.service.released.set()
    with Client(counter.endpoint, timeout_s=60) as other:
        assert other.request("count")[0] == {"count": 2}


def test_time_in_which_a_client_is_suspended_does_not_count(counter: Running) -> None:
    asking = (
        "import sys; from bridge.client import Client\n"
        "with Client(sys.argv[1], retries=0) as client: print(client.request('wait', timeout_s=10.0)[0])"
    )
    client = subprocess.Popen(
        [sys.executable, "-c", asking, counter.endpoint], stdout=subprocess.PIPE, text=True
    )
    while not counter.service.count:
        assert client.poll() is None
        time.sleep(0.01)
    client.send_signal(signal.SIGSTOP)
    time.sleep(12.0)
    client.send_signal(signal.SIGCONT)
    time.sleep(0.3)
    counter.service.released.set()
    assert client.communicate(timeout=60)[0].strip() == "{'count': 1}"
