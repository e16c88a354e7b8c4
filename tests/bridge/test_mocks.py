import numpy as np
import pytest

from bridge.arrays import array_sha256
from bridge.errors import ServerError
from bridge.mocks import MockImageServer, MockVisionServer
from tests.bridge.mock_clients import SETTINGS, captured, client_of


class TestVisionDefaults:
    def test_the_device_is_the_papers(self, mock_vision_server: MockVisionServer) -> None:
        with client_of(mock_vision_server) as client:
            result = client.request("start", {"image_server": "ipc:///tmp/none"})[0]
        device = result["describe"]
        assert [light["levels"] for light in device["lights"]] == [8, 8, 8]
        assert (len(device["shutters_s"]), len(device["apertures"])) == (5, 3)
        assert device["events"] == mock_vision_server.events
        assert result["model"]["lines"] > 0

    def test_light_and_exposure_show_in_the_statistics(self, mock_vision_server: MockVisionServer) -> None:
        with client_of(mock_vision_server) as client:
            normal = captured(client, "i1")["statistics"]
            dark = captured(client, "i2", lights=[0, 0, 0], shutter_s=1 / 240)["statistics"]
            white = captured(client, "i3", shutter_s=1 / 15)["statistics"]
        assert dark["p50"] < normal["p50"] < white["p50"]
        assert dark["dark_fraction"] > 0.9
        assert normal["saturated_fraction"] == 0
        assert white["saturated_fraction"] > 0.5
        assert set(normal["frame"]) >= {"mean", "p05", "p50", "p95"}

    def test_the_error_falls_as_the_set_grows(self, mock_vision_server: MockVisionServer) -> None:
        with client_of(mock_vision_server) as client:
            names = [captured(client, f"i{n}")["image"] for n in range(4)]
            fixes = [client.request("estimate", {"images": names[: n + 1]})[0] for n in range(4)]
            best = client.request("best")[0]
        for key in ("rms_px", "uncertainty", "ambiguity"):
            values = [fix[key] for fix in fixes]
            assert values == sorted(values, reverse=True)
            assert len(set(values)) == 4
        assert np.array(fixes[0]["covariance"]).shape == (6, 6)
        assert set(fixes[0]["seconds"]) == {"edges", "linking", "matching", "refinement"}
        assert best == fixes[-1]

    def test_black_images_give_no_pose(self, mock_vision_server: MockVisionServer) -> None:
        with client_of(mock_vision_server) as client:
            captured(client, "i1", lights=[0, 0, 0], shutter_s=1 / 240)
            assert client.request("estimate", {"images": ["i1"]})[0]["pose"] is None

    def test_discarded_and_unknown_images_are_errors(self, mock_vision_server: MockVisionServer) -> None:
        with client_of(mock_vision_server) as client:
            captured(client, "i1")
            client.request("discard", {"image": "i1"})
            for op, args in (("discard", {"image": "i1"}), ("estimate", {"images": ["i1"]})):
                with pytest.raises(ServerError, match="no image 'i1'"):
                    client.request(op, args)

    def test_a_name_is_used_once(self, mock_vision_server: MockVisionServer) -> None:
        with client_of(mock_vision_server) as client:
            captured(client, "i1")
            client.request("discard", {"image": "i1"})
            with pytest.raises(ServerError, match="already"):
                captured(client, "i1")
            client.request("start", {"image_server": "ipc:///tmp/none"})
            assert captured(client, "i1")["image"] == "i1"

    def test_restore_brings_images_back(self, mock_vision_server: MockVisionServer) -> None:
        args = {"image_server": "ipc:///tmp/none", "out": "/tmp/run", "images": ["i1", "i4"]}
        with client_of(mock_vision_server) as client:
            client.request("restore", args)
            assert client.request("estimate", {"images": ["i1", "i4"]})[0]["pose"] is not None

    def test_parameters_add_up(self, mock_vision_server: MockVisionServer) -> None:
        with client_of(mock_vision_server) as client:
            client.request("parameters", {"a": 1})
            assert client.request("parameters", {"b": "x"})[0] == {"a": 1, "b": "x"}

    def test_settings_are_checked_against_the_device(self, mock_vision_server: MockVisionServer) -> None:
        with client_of(mock_vision_server) as client:
            with pytest.raises(ServerError, match="no level 8"):
                captured(client, "i1", lights=[0, 0, 8])
            with pytest.raises(ServerError, match="2 light levels were given for 3"):
                captured(client, "i1", lights=[0, 0])


class TestImageDefaults:
    def test_a_frame_comes_with_its_header(self, mock_image_server: MockImageServer) -> None:
        with client_of(mock_image_server) as client:
            header, (pixels,) = client.request("capture", {"settings": SETTINGS})
            brighter = client.request("capture", {"settings": {**SETTINGS, "shutter_s": 1 / 30}})[1][0]
        assert (pixels.shape, pixels.dtype) == ((48, 64), np.uint8)
        assert header["sha256"] == array_sha256(pixels)
        assert (header["sequence"], header["verified"]) == (1, True)
        assert brighter.mean() > pixels.mean()

    def test_describe_move_score_health(self, mock_image_server: MockImageServer) -> None:
        with client_of(mock_image_server) as client:
            assert client.request("describe")[0]["device"] == "mock"
            assert client.request("move", {"range_m": 0.4})[0]["range_m"] == 0.4
            assert client.request("health")[0]["requests"] == {"describe": 1, "move": 1, "health": 1}
            pose = {"rotation_vector": [0, 0, 0], "translation": [0, 0, 1]}
            assert client.request("score", {"pose": pose})[0] == {"error": None}
