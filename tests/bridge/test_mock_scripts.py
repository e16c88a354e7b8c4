"""What mock servers answer instead, when they are told to."""

import json
import sys
import threading
import time
from pathlib import Path
from typing import Any

import msgspec
import pytest
import zmq

from bridge.client import Client
from bridge.errors import BadInput, BridgeTimeout, DeviceError, ProtocolError, ServerError
from bridge.mocks import MockImageServer, MockVisionServer, main
from bridge.vision_messages import EstimateResult
from tests.bridge.mock_clients import SETTINGS, captured, client_of
from tests.commands import started

from .conftest import wait_until


class TestScripts:
    def test_answers_come_in_turn_and_the_last_stays(self, mock_vision_server: MockVisionServer) -> None:
        mock_vision_server.answer("best", {"score": 1}, DeviceError("Broken."), lambda args: {"n": 3})
        with client_of(mock_vision_server) as client:
            assert client.request("best")[0]["score"] == 1
            with pytest.raises(ServerError, match="Broken") as caught:
                client.request("best")
            assert caught.value.code == "device_error"
            assert [client.request("best")[0]["n"] for _ in range(2)] == [3, 3]
            mock_vision_server.answer("best")
            assert client.request("best")[0]["pose"] is None

    def test_fields_of_a_default_answer_can_be_replaced(self, mock_vision_server: MockVisionServer) -> None:
        mock_vision_server.amend("estimate", rms_px=9.5)
        with client_of(mock_vision_server) as client:
            captured(client, "i1")
            fix = client.request("estimate", {"images": ["i1"]})[0]
        assert fix["rms_px"] == 9.5
        assert fix["pose"] is not None

    def test_what_an_answer_leaves_out_is_as_by_default(self, mock_vision_server: MockVisionServer) -> None:
        mock_vision_server.answer("estimate", {"pose": None}, {"score": 0.5})
        mock_vision_server.amend("estimate", rms_px=9.5)
        with client_of(mock_vision_server) as client:
            captured(client, "i1")
            lost, found = (client.request("estimate", {"images": ["i1"]})[0] for _ in range(2))
        for told in lost, found:
            assert msgspec.convert(told, EstimateResult).rms_px == 9.5
        assert (lost["pose"], found["score"]) == (None, 0.5)
        assert found["pose"] is not None

    def test_a_scripted_frame_is_still_one(self, mock_image_server: MockImageServer) -> None:
        mock_image_server.answer("capture", {"verified": False})
        with client_of(mock_image_server) as client:
            header, arrays = client.request("capture", {"settings": SETTINGS})
        assert header["verified"] is False
        assert len(arrays) == 1

    def test_what_a_result_has_not_cannot_be_scripted(self, mock_vision_server: MockVisionServer) -> None:
        with pytest.raises(BadInput, match=r"The result of 'estimate' has no 'rms'\. It has pose,"):
            mock_vision_server.answer("estimate", {"rms": 1.0})
        with pytest.raises(BadInput, match="no 'rms'"):
            mock_vision_server.amend("estimate", rms=1.0)
        mock_vision_server.amend("health", camera="ok")  # which tells what it likes

    def test_no_reply_comes_before_it_is_asked_for(self, mock_vision_server: MockVisionServer) -> None:
        with pytest.raises(BadInput, match="A delay of -1 s"):
            mock_vision_server.delay("best", -1)

    def test_a_lost_reply_is_asked_for_again_and_done_once(
        self, mock_vision_server: MockVisionServer
    ) -> None:
        mock_vision_server.drop("capture", times=2)
        with Client(mock_vision_server.endpoint, timeout_s=60, retries=59) as client:
            assert captured(client, "i1")["image"] == "i1"
        assert len(mock_vision_server.requests_of("capture")) == 1

    def test_a_lost_reply_does_not_touch_other_operations(self, mock_vision_server: MockVisionServer) -> None:
        mock_vision_server.drop("capture", times=9)
        with client_of(mock_vision_server, timeout_s=0.3) as client:
            with pytest.raises(BridgeTimeout):
                captured(client, "i1")
            assert client.request("hello", timeout_s=60)[0]["server"] == "mock vision server"

    def test_a_garbled_reply(self, mock_vision_server: MockVisionServer) -> None:
        mock_vision_server.garble("best")
        with client_of(mock_vision_server) as client:
            with pytest.raises(ProtocolError):
                client.request("best")
            assert client.request("best")[0]["pose"] is None

    def test_a_late_reply(self, mock_vision_server: MockVisionServer) -> None:
        mock_vision_server.delay("best", 0.3)
        with client_of(mock_vision_server) as client:
            begun = time.monotonic()
            client.request("best")
            assert time.monotonic() - begun >= 0.3

    def test_death_and_resurrection(self, mock_vision_server: MockVisionServer) -> None:
        mock_vision_server.die("best")
        with client_of(mock_vision_server, timeout_s=0.5) as client:
            with pytest.raises(BridgeTimeout):
                client.request("best")
            assert wait_until(lambda: not mock_vision_server.running)
            mock_vision_server.start()
            assert client.request("best", timeout_s=60)[0]["pose"] is None

    def test_requests_are_recorded(self, mock_vision_server: MockVisionServer) -> None:
        with client_of(mock_vision_server) as client:
            captured(client, "i1", lights=[1, 2, 3])
            client.request("discard", {"image": "i1"})
        assert [request.op for request in mock_vision_server.requests] == ["capture", "discard"]
        assert mock_vision_server.requests_of("capture")[0]["settings"]["lights"] == (1, 2, 3)

    def test_wrong_requests_are_refused_before_the_script(self, mock_vision_server: MockVisionServer) -> None:
        mock_vision_server.answer("discard", {"images": []})
        with client_of(mock_vision_server) as client, pytest.raises(ServerError, match="unknown field"):
            client.request("discard", {"picture": "i1"})

    def test_an_operation_that_does_not_exist_cannot_be_scripted(
        self, mock_vision_server: MockVisionServer
    ) -> None:
        with pytest.raises(BadInput, match="no operation 'dance'"):
            mock_vision_server.answer("dance", {})

    def test_events_can_be_published(self, mock_vision_server: MockVisionServer) -> None:
        with zmq.Context() as context, context.socket(zmq.SUB) as sub:
            sub.linger = 0
            sub.subscribe(b"")
            sub.connect(mock_vision_server.events)
            assert sub.poll(60_000)
            sub.recv()
            mock_vision_server.publish("light_fault", {"light": "left"})
            told: Any = {}
            while told.get("event") != "light_fault":  # its beats go on
                assert sub.poll(60_000)
                told = sub.recv_json()
            assert told["args"] == {"light": "left"}

    def test_the_thread_that_serves_is_the_only_one_that_sends(
        self, mock_vision_server: MockVisionServer, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        senders: list[str] = []
        send = zmq.Socket.send

        def noted(sock: Any, *args: Any, **options: Any) -> Any:
            if sock.type == zmq.XPUB:
                senders.append(threading.current_thread().name)
            return send(sock, *args, **options)

        monkeypatch.setattr(zmq.Socket, "send", noted)
        for number in range(1, 51):
            assert mock_vision_server.publish("sun_changed") == number
        assert wait_until(lambda: len(senders) == 50)
        assert senders == [mock_vision_server.name] * 50


def test_a_mock_as_a_process_follows_its_script(folder: Path, root: Path) -> None:
    script = folder / "script.json"
    error = {"error": {"code": "device_error", "message": "Lamp out.", "hint": ""}}
    script.write_text(
        json.dumps({"best": {"answers": [{"score": 1}, error]}, "estimate": {"amend": {"rms_px": 7}}})
    )
    command = [sys.executable, "-m", "bridge.mocks", "vision", "--endpoint", f"ipc://{folder}/v"]
    with started([*command, "--script", str(script)], cwd=root) as process:
        with Client(f"ipc://{folder}/v", timeout_s=60, retries=60) as client:
            assert client.request("best")[0]["score"] == 1
            with pytest.raises(ServerError, match="Lamp out"):
                client.request("best")
            captured(client, "i1")
            assert client.request("estimate", {"images": ["i1"]})[0]["rms_px"] == 7
            client.request("shutdown")
        assert process.wait(60) == 0


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ('{"best": {"answer": []}}', "The script of 'best': Object contains unknown field `answer`"),
        ('{"capure": {"delay_s": 1}}', "The mock vision server has no operation 'capure'. It has start,"),
        ('{"capture": {"delay_s": -1}}', "The script of 'capture': Expected `float` >= 0.0 - at `$.delay_s`"),
        ('{"estimate": {"amend": {"rms": 1}}}', "The result of 'estimate' has no 'rms'"),
        ('{"best": {"answers": [{"rms": 1}]}}', "The result of 'best' has no 'rms'"),
        ('{"best": {"answers": [{"error": {"code": "x"}}]}}', "missing required field `message`"),
        ('{"best": {"drop": "once"}}', "Expected `int`, got `str` - at `$.drop`"),
        ("{'best': 1}", "is no JSON object: JSON is malformed"),
        ("[]", "is no JSON object: Expected `object`, got `array`"),
        (None, "Cannot read the script"),
    ],
)
def test_a_wrong_script_is_explained(
    folder: Path, capsys: pytest.CaptureFixture[str], text: str | None, complaint: str
) -> None:
    script = folder / "script.json"
    if text is not None:
        script.write_text(text)
    assert main(["vision", "--endpoint", f"ipc://{folder}/v", "--script", str(script)]) == 2
    assert complaint in capsys.readouterr().err
