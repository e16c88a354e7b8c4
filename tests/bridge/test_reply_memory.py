from bridge.reply_memory import ReplyMemory


def add(memory: ReplyMemory, request_id: str, size: int = 10) -> None:
    memory.add(request_id, b"q", [b"r" * size], size)


def test_a_reply_is_found_by_its_request() -> None:
    memory = ReplyMemory()
    add(memory, "a/1")
    found = memory.get("a/1")
    assert found is not None
    assert (found.request, found.frames) == (b"q", [b"r" * 10])
    assert memory.get("a/2") is None
    assert memory.get("b/1") is None


def test_the_oldest_replies_of_a_client_go_first() -> None:
    memory = ReplyMemory(replies=3)
    for n in range(5):
        add(memory, f"a/{n}")
    add(memory, "b/0")
    assert [memory.get(f"a/{n}") is not None for n in range(5)] == [False, False, True, True, True]
    assert memory.get("b/0") is not None


def test_the_client_that_fell_silent_goes_first() -> None:
    memory = ReplyMemory(clients=2)
    add(memory, "a/1")
    add(memory, "b/1")
    add(memory, "a/2")
    add(memory, "c/1")
    assert memory.get("a/1") is not None
    assert memory.get("b/1") is None
    assert memory.bytes == 3 * 11


def test_bytes_are_bounded_but_the_newest_reply_stays() -> None:
    memory = ReplyMemory(size=100)
    for n in range(20):
        add(memory, f"a/{n}", 30)
    assert memory.bytes <= 100
    assert memory.get("a/19") is not None
    add(memory, "b/1", 1000)
    assert memory.get("b/1") is not None
    assert len(memory) == 1
