"""How much a connection without keys has sent of a message: ZMTP's frames are counted
(rfc.zeromq.org/spec/23).
"""

from __future__ import annotations

import struct

from bridge.envelope import MAX_FRAME_BYTES, MAX_FRAMES, MAX_MESSAGE_BYTES

MAX_COMMAND_BYTES = 4096
"""Of one ZMTP command: the handshake's metadata is the largest, with an identity of 255 bytes."""
GREETING_BYTES = 64  # of ZMTP 3
MORE, LONG, COMMAND = 1, 2, 4  # flags of a frame


class TooMuchError(Exception):
    """A client broke a bound."""


class FrameMeter:
    """Follows one direction of a ZMTP 3 connection without keys.

    Attributes
    ----------
    unfinished
        Bytes of the message under way, frame heads included; 0 between messages.
    """

    def __init__(self) -> None:
        self.unfinished = 0
        self._frames = 0
        self._body = GREETING_BYTES  # left of the frame under way; at first the greeting, which is none
        self._last = True
        self._head = bytearray()
        self._greeting: bytearray | None = bytearray()

    @property
    def midway(self) -> bool:
        """Whether something has begun that is not complete."""
        return self.unfinished > 0 or bool(self._head) or self._body > 0

    def feed(self, data: memoryview) -> None:
        """Count bytes as they pass.

        Raises
        ------
        TooMuchError
            A frame, a command, a message or its number of frames beyond its bound; or no ZMTP 3.
        """
        at, end = 0, len(data)
        while at < end:
            if self._body:
                step = min(self._body, end - at)
                if self._greeting is not None:
                    self._greeting += data[at : at + step]
                    self._check_greeting(self._greeting)
                self._body -= step
                at += step
            else:
                self._greeting = None
                self._head += data[at : at + 1]
                at += 1
                self._read_head()
            if not self._body and not self._head and self._last:
                self.unfinished = self._frames = 0

    def _read_head(self) -> None:
        head = self._head
        flags = head[0]
        if len(head) < (9 if flags & LONG else 2):
            return
        size = struct.unpack(">Q", head[1:])[0] if flags & LONG else head[1]
        self._head = bytearray()
        if size > (MAX_COMMAND_BYTES if flags & COMMAND else MAX_FRAME_BYTES):
            raise TooMuchError(f"a frame of {size} bytes")
        self._frames += 1
        self.unfinished += size + len(head)
        if self.unfinished > MAX_MESSAGE_BYTES or self._frames > MAX_FRAMES:
            raise TooMuchError(f"a message of {self._frames} frames and {self.unfinished} bytes")
        self._body = size
        if not flags & COMMAND:
            self._last = not flags & MORE

    @staticmethod
    def _check_greeting(greeting: bytearray) -> None:
        if greeting[0] != 0xFF or (len(greeting) > 9 and greeting[9] != 0x7F):
            raise TooMuchError("no ZMTP")
        if len(greeting) > 10 and greeting[10] < 3:
            raise TooMuchError(f"ZMTP {greeting[10]}")
