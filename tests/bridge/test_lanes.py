"""Work of many callers side by side, and a system that gives no thread for it."""

from threading import Event, Thread

import pytest

from bridge import lanes
from bridge.client import Client
from bridge.errors import ServerError
from bridge.lanes import MAX_LANES, Lanes

from .conftest import Running


def test_what_is_prompt_is_done_however_many_callers_there_are() -> None:
    many, may_go_on, done = Lanes(), Event(), Event()

    def wait() -> None:
        may_go_on.wait(60.0)

    try:
        for number in range(MAX_LANES):
            assert many.put(str(number).encode(), wait, 1)
        assert not many.put(b"another", done.set, 1)
        assert many.put(b"another", done.set, 1, prompt=True)
        assert done.wait(60.0)
    finally:
        may_go_on.set()
        many.join()


def refuse(*_: object, **__: object) -> None:
    raise RuntimeError("can't start new thread")


def test_a_server_without_a_thread_for_a_request_is_busy_and_serves_on(
    counter: Running, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Client(counter.endpoint, timeout_s=60.0) as client:
        client.request("hello")
        with monkeypatch.context() as without:
            without.setattr(lanes, "Thread", refuse)
            with pytest.raises(ServerError, match="too many requests"):
                client.request("count")
        assert client.request("count")[0] == {"count": 1}


def test_a_connection_without_a_thread_is_closed_and_forgotten(
    counter: Running, monkeypatch: pytest.MonkeyPatch
) -> None:
    start, tried = Thread.start, Event()

    def refused_once(thread: Thread) -> None:
        if thread.name == "gate" and not tried.is_set():
            tried.set()
            refuse()
        start(thread)

    monkeypatch.setattr(Thread, "start", refused_once)
    with Client(counter.endpoint, timeout_s=60.0) as client:
        assert client.request("count")[0] == {"count": 1}
    assert tried.is_set()
    counter.stop()
