import hashlib

import numpy as np
import pytest
import zmq
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from bridge.arrays import DTYPES, ArrayDescription, array_sha256, pack, unpack
from bridge.errors import ProtocolError


def frames_of(arrays: list[np.ndarray]) -> list[zmq.Frame]:
    return [zmq.Frame(array.tobytes()) for array in arrays]


@given(
    st.sampled_from(sorted(DTYPES)).flatmap(
        lambda name: hnp.arrays(
            np.dtype(name), hnp.array_shapes(min_dims=1, max_dims=4, min_side=0, max_side=5)
        )
    )
)
def test_any_array_comes_back_as_it_was(array: np.ndarray) -> None:
    described, packed = pack([array])
    (back,) = unpack(described, frames_of(packed))
    assert back.dtype == array.dtype
    assert back.shape == array.shape
    assert back.tobytes() == array.tobytes()


def test_views_and_other_byte_orders_are_sent_as_plain_arrays() -> None:
    base = np.arange(24, dtype=">i4").reshape(4, 6)
    described, packed = pack([base[::2, ::-1]])
    (back,) = unpack(described, frames_of(packed))
    np.testing.assert_array_equal(back, base[::2, ::-1])


def test_a_contiguous_array_is_not_copied() -> None:
    array = np.zeros((4, 5), np.uint8)
    assert np.shares_memory(pack([array])[1][0], array)


def test_text_and_objects_are_not_sent() -> None:
    with pytest.raises(TypeError, match="cannot be sent"):
        pack([np.array([object()])])


@pytest.mark.parametrize(
    ("dtype", "shape", "size", "complaint"),
    [
        ("uint8", (2, 3), 5, "should have 6 bytes"),
        ("object", (1,), 8, "described as object"),
        ("uint8", (-1, -6), 6, "described as"),
        ("uint8", (1, 1, 1, 1, 1), 1, "described as"),
        ("float64", (2**40, 2**40), 8, "should have"),
    ],
)
def test_a_description_that_does_not_fit_is_refused(
    dtype: str, shape: tuple[int, ...], size: int, complaint: str
) -> None:
    with pytest.raises(ProtocolError, match=complaint):
        unpack([ArrayDescription(dtype, shape)], [zmq.Frame(bytes(size))])


def test_a_missing_frame_is_refused() -> None:
    with pytest.raises(ProtocolError, match="describes 1 arrays but 0"):
        unpack([ArrayDescription("uint8", (1,))], [])


def test_sha256_is_over_the_bytes_in_c_order() -> None:
    array = np.arange(6, dtype=np.uint8).reshape(2, 3)
    assert array_sha256(array) == hashlib.sha256(bytes(range(6))).hexdigest()
    assert array_sha256(array.T) == hashlib.sha256(bytes([0, 3, 1, 4, 2, 5])).hexdigest()
