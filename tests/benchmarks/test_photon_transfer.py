"""What a laboratory would measure on the simulated camera's frames is what was put in."""

import numpy as np
import pytest

from benchmarks.photon_transfer import bracket, camera_with, linearity, transfer

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(("gain", "read_noise_e", "full_well_e"), [(2.0, 40.0, 10000.0), (4.0, 15.0, 5000.0)])
def test_photon_transfer_tells_gain_well_and_read_noise(
    gain: float, read_noise_e: float, full_well_e: float
) -> None:
    found = transfer(camera_with(gain, read_noise_e, full_well_e), bracket(gain), pairs=2)
    assert len(found.mean) > 8
    assert found.slope == pytest.approx(gain / full_well_e, rel=0.05)
    foot = (read_noise_e * gain / full_well_e) ** 2
    assert found.foot == pytest.approx(foot, abs=0.05 * foot + 0.02 * gain / full_well_e)


def test_signal_follows_exposure_times_radiance() -> None:
    wanted, found = linearity(camera_with(2.0, 6.0, 10000.0), patches=4)
    assert len(wanted) > 12
    assert np.ptp(wanted) > 0.5
    assert np.abs(found - wanted).max() < 0.001
