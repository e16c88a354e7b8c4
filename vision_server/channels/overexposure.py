"""By how much images are overexposed whose exposures nobody told.

Another light makes some of a scene brighter and some of it darker. An image that is brighter than all others
nearly everywhere was not lit better, it was exposed for longer; taken for well lit, it would have all the say
where it is not clipped, and hide what the others show where it is.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vision_server.channels.depth import Pixels, in_grey, is_deep
from vision_server.channels.noise import SATURATED_GREY

# Chosen by hand where nothing else is said.
STEP = 2  # of the pixels that are compared
LIT_GREY = 16  # darker pixels tell no ratio
LEAST_STOPS = 0.5  # on six stacks, one lamp each and all together, no image was brighter by as much
FEWEST = 200  # pixels that tell a ratio


def overexposures(images: Sequence[Pixels], gamma: Sequence[float]) -> list[float]:
    """For each image of a set, the exposure by which it is brighter than all others; 1 for most.

    Parameters
    ----------
    images
        Grey (H, W) of one scene under different lights.
    gamma
        Tone curve of each: linear = grey^gamma.

    Returns
    -------
    The median ratio to the brightest other image, where neither is dark and one is not clipped: of the pixels
    that are not clipped in the image, or of all of them, whose clipped ones give a lower bound. The larger
    one; what is not clipped may lie in shadow. Where only the other is clipped, that is brighter: without
    such pixels what lights another's shadows would seem overexposed itself.
    """
    sampled = (image[::STEP, ::STEP] for image in images)
    seen = [in_grey(one) if is_deep(one) else one for one in sampled]
    out = []
    for k, image in enumerate(seen):
        others = seen[:k] + seen[k + 1 :]
        if not others:
            return [1.0]
        # tone curves are monotonic, and the same in most sets: the brightest grey is the brightest light
        brightest = np.max(others, axis=0)
        lit = (np.minimum(brightest, image) >= LIT_GREY) & (np.minimum(brightest, image) < SATURATED_GREY)
        medians = [
            float(np.median(image[compared] / brightest[compared].astype(np.float64)))
            for compared in (lit, lit & (image < SATURATED_GREY))
            if compared.sum() >= FEWEST
        ]
        stops = gamma[k] * np.log2(max(medians, default=1.0))
        out.append(float(2.0**stops) if stops >= LEAST_STOPS else 1.0)
    return out
