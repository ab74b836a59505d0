"""How large noise is where a joint's signal was never measured: nothing is said of it, and nothing of the others is
lost."""

import numpy as np
from realitygap.diagnose.data.noise import repetition_noise
from realitygap.recording.noise import own_noise


def test_a_signal_that_was_never_measured_has_no_noise_and_changes_no_other() -> None:
    noise = 0.1 * np.random.default_rng(0).normal(size=(3, 500, 2))
    gaps = noise.copy()
    gaps[:, :, 1] = np.nan
    gaps[0, :50, 0] = np.nan  # the other repetitions tell
    np.testing.assert_array_equal(own_noise(gaps[1]), [own_noise(noise[1])[0], 0.0])
    pooled = repetition_noise(list(gaps))
    assert pooled[1] == 0.0
    np.testing.assert_allclose(pooled[0], 0.1, rtol=0.05)
    np.testing.assert_allclose(repetition_noise(list(noise)), np.sqrt(noise.var(axis=0, ddof=1).mean(axis=0)))
