"""Work of many callers side by side."""

from threading import Event

from bridge.lanes import MAX_LANES, Lanes


def test_what_is_prompt_is_done_however_many_callers_there_are() -> None:
    lanes, may_go_on, done = Lanes(), Event(), Event()

    def wait() -> None:
        may_go_on.wait(60.0)

    try:
        for number in range(MAX_LANES):
            assert lanes.put(str(number).encode(), wait, 1)
        assert not lanes.put(b"another", done.set, 1)
        assert lanes.put(b"another", done.set, 1, prompt=True)
        assert done.wait(60.0)
    finally:
        may_go_on.set()
        lanes.join()
