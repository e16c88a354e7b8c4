"""Requests that are nearly right, for the hostile crowd: each operation, with odd values in odd places."""

from __future__ import annotations

import copy
import json
import random
from typing import Any

SETTINGS = {"lights": [5, 5, 5], "shutter_s": 1 / 60, "aperture": 4.0}
POSE = {"rotation_vector": [0.1, 0.2, 0.3], "translation": [0.0, 0.0, 0.6]}
IMAGE_REQUESTS: dict[str, dict[str, Any]] = {
    "describe": {},
    "capture": {"settings": SETTINGS},
    "health": {},
    "restart": {"seed": 1, "captures_taken": 2},
    "move": {"range_m": 0.7},
    "score": {"pose": POSE},
    "hello": {},
}
VISION_REQUESTS: dict[str, dict[str, Any]] = {
    "start": {"image_server": "IMAGES", "seed": 3, "out": "FOLDER", "matcher": "search"},
    "capture": {"image": "i1", "settings": SETTINGS},
    "add": {"image": "i2", "settings": SETTINGS},
    "estimate": {"images": ["i1"]},
    "discard": {"image": "i1"},
    "best": {},
    "predict": {"settings": [SETTINGS], "images": ["i1"], "search": 1},
    "appraise": {"image": "i1"},
    "check": {"pose": POSE, "images": ["i1"]},
    "track": {"time_s": 0.1},
    "parameters": {"seed": 1, "generations": 20, "seed_pose": POSE},
    "restore": {"image_server": "IMAGES", "out": "FOLDER", "images": ["i1"], "discarded": [], "told": []},
    "end": {},
    "hello": {},
    "health": {},
}
RUN = "hostile-run"
SELDOM = {"end", "discard", "start"}
"""One in ten of the others: what they undo, the others need."""
WITH_ARRAYS = {"add", "track"}
FRAME = bytes(640 * 480)
FRAMES_SENT = 0.1
"""Share of the requests that take a frame which have one."""
ODD: list[Any] = [
    None, True, -1, 0, 1e-300, 1e300, -1e308, 2**63, 10**30, 10**400, "", "\0", "i1\n", "a" * 5000, "../../x",
    "/dev/zero", "/dev/stdin", "/etc/passwd", "ipc:///nowhere", "tcp://127.0.0.1:1", "best", [], {}, [[]],
    [1e308] * 3, ["i1"] * 300, {"best_at_range_m": 1e-300}, {"best_at_range_m": 1e308}, "é\u2028\U0001f6f0",
]  # fmt: skip
AS_IT_IS = 0.02
"""Share of requests that are sent without a mutation: they cost most."""


class Mutator:
    """Requests that are nearly right."""

    def __init__(self, requests: dict[str, dict[str, Any]], seed: int) -> None:
        self._random = random.Random(seed)
        self._requests = requests
        self._weights = [0.1 if op in SELDOM else 1.0 for op in requests]
        self._name = f"hostile-{seed}"
        self._number = 0

    def message(self) -> list[bytes]:
        """The frames of one message."""
        draw = self._random
        self._number += 1
        op = draw.choices(list(self._requests), self._weights)[0]
        args = json.loads(json.dumps(self._requests[op]))
        request: dict[str, Any] = {"v": 1, "id": f"{self._name}/{self._number}", "op": op, "args": args}
        arrays = []
        if op in WITH_ARRAYS and draw.random() < FRAMES_SENT:
            request["arrays"], arrays = [{"dtype": "uint8", "shape": [480, 640]}], [FRAME]
        if draw.random() >= AS_IT_IS:
            for _ in range(draw.randint(1, 3)):
                self._mutate(request if draw.random() < 0.15 else args)
        header = json.dumps(request).encode()
        if draw.random() < 0.2:
            header = self._bytes(header)
        if draw.random() < 0.03:
            header = draw.randbytes(draw.choice([0, 1, 30, 3000]))
        frames = [
            header,
            *arrays,
            *(draw.randbytes(draw.choice([0, 5, 3000])) for _ in range(draw.choice([0] * 9 + [1, 3]))),
        ]
        if b"shutdown" in header:
            return [b"{}"]
        return frames

    def _mutate(self, value: Any) -> None:
        """Change one thing somewhere inside."""
        draw = self._random
        keys = list(value) if isinstance(value, dict) else list(range(len(value)))
        if not keys or draw.random() < 0.1:
            if isinstance(value, dict):
                value[draw.choice(["colour", "", "image", "seed_pose", "a" * 300])] = copy.deepcopy(
                    draw.choice(ODD)
                )
            else:
                value.append(copy.deepcopy(draw.choice(ODD)))
            return
        key = draw.choice(keys)
        if isinstance(value[key], (dict, list)) and draw.random() < 0.7:
            self._mutate(value[key])
        elif draw.random() < 0.15:
            del value[key]
        else:
            value[key] = copy.deepcopy(draw.choice(ODD))

    def _bytes(self, header: bytes) -> bytes:
        draw = self._random
        changed = bytearray(header)
        for _ in range(draw.randint(1, 4)):
            at = draw.randrange(len(changed))
            match draw.randrange(4):
                case 0:
                    changed[at] = draw.randrange(256)
                case 1:
                    del changed[at : at + draw.randint(1, 20)]
                    changed += b" "
                case 2:
                    changed[at:at] = changed[: draw.randint(1, 40)]
                case _:
                    changed[at:at] = draw.choice([b'"', b"{", b"[" * 2000, b"1e999", b"9" * 50, b"\\u0000"])
        return bytes(changed)
