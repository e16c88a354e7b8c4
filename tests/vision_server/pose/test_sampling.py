import numpy as np
import pytest

from geometry.model import Model
from geometry.visibility import DENSEST_PX, visible_samples
from tests.vision_server.synthetic import CAMERA, POSE
from vision_server.pose.sampling import SAMPLES_A_TARGET, spacing_for, thinned


@pytest.mark.parametrize("most", [1, 5, 12, 1000])
def test_thinned_lines_keep_their_length_with_few_samples(model: Model, most: int) -> None:
    samples = visible_samples(model, CAMERA, POSE, 3.0)
    few = thinned(samples, most)
    before, after = (np.bincount(one.line, one.px, len(model.lines)) for one in (samples, few))
    np.testing.assert_allclose(after, before)
    counts, kept = (np.bincount(one.line, minlength=len(model.lines)) for one in (samples, few))
    np.testing.assert_array_equal(kept, np.minimum(counts, most))


def test_thinned_samples_are_spread_evenly(model: Model) -> None:
    samples = visible_samples(model, CAMERA, POSE, 1.0)
    few = thinned(samples, 10)
    line = int(np.bincount(samples.line).argmax())
    places = few.image[few.line == line]
    gaps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert gaps.max() < 1.5 * gaps.min() + 1.0


def test_the_spacing_bounds_the_number_of_samples(model: Model) -> None:
    near = POSE.__class__(POSE.rotation_vector, 0.4 * POSE.translation)
    for pose in (POSE, near):
        spacing = spacing_for(model, CAMERA, pose)
        assert spacing >= DENSEST_PX
        assert len(visible_samples(model, CAMERA, pose, spacing).line) < 1.1 * SAMPLES_A_TARGET
