"""The target's pose in every frame: followed while it can be, said to be lost when it cannot, found again."""

from __future__ import annotations

import time

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Floats
from vision_server.channels.depth import Pixels
from vision_server.channels.tone import KNOWN_TONE_SD_PX
from vision_server.judgement import Estimate
from vision_server.matching.match import Anywhere
from vision_server.pipeline import PipelineSettings
from vision_server.pose.trust import TAILS, quality
from vision_server.tracking.acceptance import (
    HELD,
    STAYS,
    SURE,
    are_unlikely,
    belief_in,
    found_belief,
    is_elsewhere,
    is_exact,
    is_likely,
    is_partly_whole,
    is_probable,
    is_sure,
    is_whole,
    told_covariance,
    whole_lines,
)
from vision_server.tracking.choosing import likeliest
from vision_server.tracking.clock import Clock
from vision_server.tracking.fitting import Habits
from vision_server.tracking.following import NEAR_REACHES_PX, Found, Sight
from vision_server.tracking.frame import Tone, check_size
from vision_server.tracking.motion import Innovation, Motion
from vision_server.tracking.narrow import firmest
from vision_server.tracking.rivals import Rivals
from vision_server.tracking.round_parts import turn_is_seen
from vision_server.tracking.searching import Search, everywhere_is_due, widened_by
from vision_server.tracking.softness import Softness
from vision_server.tracking.strain import Strain
from vision_server.tracking.tracked import State, Tracked
from vision_server.tracking.turning import Turning
from vision_server.tracking.usual import Usual

Seen = tuple[State, Pose | None, Floats | None, dict[int, float] | None]

# Chosen by hand where nothing else is said.
EXPECTED, SURPRISING = 16.8, 38.3  # squared innovations: 1 % and 1e-6 of an honest filter's are larger
# Of the quality that is usual in its light: below, the less probable than SURE is not sure; none is believed.
SURE_LIKE, LIKE_BEFORE = 0.6, 0.25
LOOKED_AT_ANEW = 5  # frames that are not believed in a row before everything is searched again
MOST_AGAINST = 3  # searches in doubt that count: as many must believe before what they find is believed
LONGEST_S = 0.5  # without a pose, until velocity says nothing


class Tracker:
    """Follows one target through frames.

    Parameters
    ----------
    seed_pose : where the target is in the first frame, within the search range, or what is known without.
    gamma, tone_sd_px : the frames' tone curve, see `estimate_pose`.
    seed : of the searches' draws.
    edge_radius_m : of the target's rounded edges, where that is known.
    """

    def __init__(
        self,
        model: Model,
        camera: Camera,
        seed_pose: Pose | Anywhere,
        gamma: float = 1.0,
        tone_sd_px: float = KNOWN_TONE_SD_PX,
        seed: int = 0,
        edge_radius_m: float | None = None,
    ) -> None:
        self._sight = Sight(model, camera, Tone.of(gamma, tone_sd_px))
        self._settings = PipelineSettings(seed=seed, tone_sd_px=tone_sd_px)
        self._around = self._trusted = seed_pose  # the last pose, and the last believed one
        self._motion: Motion | None = None
        self._habits = Habits.of(model, edge_radius_m)
        self._rivals = Rivals()
        self._steady = False  # whether the last frame was followed surely
        self._softness: Softness | None = None  # its lines, of a steady frame
        self._believed = False  # whether the last search that found something believed it
        self._strain = Strain()
        self._usual = Usual(model, camera)  # what believed frames in light like this one's show
        self._was_believed = False
        self._met = False  # whether any pose was found yet
        self._misses, self._vain = 0, 0  # frames without a pose, searches that were not believed, in a row
        self._against = 0  # searches that doubted what they found, less those that did not
        self._since_s = 0.0  # the last pose
        self._doubted, self._frame = 0, -1
        self._clock, self._turning = Clock(), Turning(model)
        self._asked: tuple[Found, Motion, Innovation] | None = None

    @property
    def model(self) -> Model:
        """What is followed."""
        return self._sight.model

    @property
    def camera(self) -> Camera:
        """What sees it."""
        return self._sight.camera

    def step(self, pixels: Pixels, time_s: float | None = None) -> Tracked:
        """Look at the next frame.

        Parameters
        ----------
        pixels : grey, (H, W), of the camera's size: see `channels.depth`.
        time_s : when it was taken; without it, a thirtieth of a second after the one before.

        Raises
        ------
        BadInput : another size or type.
        """
        began = time.process_time()
        self._frame += 1
        check_size(pixels, self._sight.camera, self._frame)
        note, seconds = self._clock.passed(pixels, time_s)
        self._turning.passed(seconds)
        state, pose, covariance, support = self._seen(pixels, seconds)
        if state == "sure" and pose is not None:
            self._turning.seen(pose)
        return Tracked(self._frame, state, pose, covariance, time.process_time() - began, note, support)

    def _seen(self, pixels: Pixels, seconds: float) -> Seen:
        found = None
        if self._motion is not None:
            self._motion = self._motion.after(seconds)
            self._since_s += seconds
            found = self._followed(pixels, self._motion)
            if found is not None and found.belief(0.0) >= STAYS:
                self._rivals.weigh(found, lambda pose: self._sight.near(pixels, pose, self._habits))
            if found is not None and (self._doubted < LOOKED_AT_ANEW or self._is_believed(found)):
                return self._taken(pixels, found)
        held = found is not None and found.belief(0.0) >= HELD
        return self._searched(pixels, found if held else None)

    def _followed(self, pixels: Pixels, expected: Motion) -> Found | None:
        """The pose around the expected one, or where the target was, that a frame supports best."""
        middle = self._sight.model.middle
        start = expected.pose(middle)
        self._usual.meets(pixels, start)
        near = self._sight.near(pixels, start, self._habits, self._softness)
        foreseen = expected.spread_px(self.camera, 0.5 * self.model.diameter) < NEAR_REACHES_PX[0]
        steady = self._steady and foreseen
        if near is not None and steady and self._usual.shows(near.support) and self._is_believed(near):
            return near
        starts = [start] if isinstance(self._around, Anywhere) else [start, self._around]
        candidates = self._sight.far(pixels, starts, self._habits) + ([] if near is None else [near])
        if candidates and not foreseen:
            candidates += self._sight.turned(pixels, candidates, self._habits)
        candidates = [one for one in candidates if self._turning.allows(one.pose)]
        candidates.sort(key=lambda one: -one.quality)
        if believed := [one for one in candidates if self._is_believed(one)]:
            return likeliest(believed, expected, middle)
        held = [one for one in candidates if one.belief(0.0) >= HELD]
        if not held and self._misses == 0:
            held = [one for one in candidates if is_partly_whole(one.support) and self._is_foreseen(one)]
        return held[0] if held else None

    def _is_believed(self, found: Found) -> bool:
        if not self._believed:  # nothing but a search weighs rivals and stretched models
            return False
        return found.quality >= LIKE_BEFORE * self._usual.quality and self._is_likely(found)

    def _is_likely(self, found: Found) -> bool:
        """Whether it would be believed in light that usually shows as little."""
        return is_probable(found, self._rivals, self._was_believed) and self._is_foreseen(found)

    def _is_foreseen(self, found: Found) -> bool:
        return self._innovation(found).squared <= SURPRISING

    def _innovation(self, found: Found) -> Innovation:
        """Against the motion as it is; asked several times of one pose."""
        assert self._motion is not None
        if self._asked is None or self._asked[0] is not found or self._asked[1] is not self._motion:
            own = self._motion.innovation(found.pose, found.covariance, self._sight.model.middle)
            self._asked = found, self._motion, own
        return self._asked[2]

    def _taken(self, pixels: Pixels, found: Found) -> Seen:
        """A pose that was followed: the motion goes on from it."""
        assert self._motion is not None
        found, clear = firmest(found, self._sight, pixels, self._habits)
        believed, likely = self._is_believed(found), self._is_likely(found)
        expected = self._innovation(found).squared <= EXPECTED
        rest = Motion.at_rest(found.pose, found.covariance, self.model.middle)
        self._motion = self._motion.corrected(self._innovation(found)) if self._is_foreseen(found) else rest
        stays = expected and found.quality >= SURE_LIKE * self._usual.quality
        sure = believed and (self._was_believed or self._usual.is_other)
        sure = sure and is_sure(found, self._rivals, stays)
        self._steady = sure and not self._strain.asked(found.is_strained)
        self._held(found.pose, believed)
        if believed:
            self._usual.believed(found.quality, whole_lines(found.support) if self._steady else None)
            self._habits = self._habits.after(found.fit)
        elif likely:
            self._usual.doubted(found.quality)
        else:
            self._usual.forget_doubts()
        state: State = "sure" if self._steady and clear and turn_is_seen(found, self.model) else "unsure"
        lines = found.fit.observation.samples.line
        soft = found.softness.kept(self.model, self.camera, found.pose, lines, self._softness)
        self._softness = soft if self._steady else None
        covariance = told_covariance(found.covariance, found.belief(self._rivals.ambiguity))
        return state, found.pose, covariance, found.support.shares

    def _held(self, pose: Pose, believed: bool) -> None:
        self._around, self._met, self._misses, self._since_s = pose, True, 0, 0.0
        self._was_believed = believed
        self._doubted = 0 if believed else self._doubted + 1
        self._trusted = pose if believed else self._trusted

    def _searched(self, pixels: Pixels, followed: Found | None) -> Seen:
        """Search everything around the last pose, farther with each frame that finds nothing.

        A pose that was ``followed`` and is not believed stays unless what is found is better.
        """
        self._steady, self._softness, self._doubted = False, None, 0
        self._usual.forget_doubts()
        estimate = self._estimate(pixels, widened_by(self._misses))
        same = followed is not None and followed.is_at(estimate.pose)
        self._rivals.found(estimate, goes_on=same)
        likely = estimate.score >= HELD or is_likely(estimate, self._met)
        far = estimate.pose is not None and not self._turning.allows(estimate.pose)
        likely = likely and (not far or self._turning.stands_out(estimate))
        found = None
        if likely and estimate.pose is not None:  # on whole lines, as every frame is
            found = self._sight.near(pixels, estimate.pose, self._habits)
        found = found if found is not None and found.is_at(estimate.pose) else None
        if followed is not None and (found is None or found.quality <= followed.quality):
            confirmed = same and self._believed and found_belief(estimate, found) >= STAYS
            self._believed = confirmed or (self._judged(estimate, found) and same)
            self._was_believed = self._believed and are_unlikely(self._rivals)
            return self._taken(pixels, followed)
        if not likely or estimate.pose is None or estimate.covariance is None:
            self._misses, self._was_believed = self._misses + 1, False
            self._motion = None if self._since_s > LONGEST_S else self._motion
            return "lost", None, None, None
        assert estimate.support is not None
        if far:  # one witness is not enough: the next search is the second
            self._turning.seen(estimate.pose)
        self._believed = self._judged(estimate, found) and not far
        believed = self._believed and are_unlikely(self._rivals)
        clear, pose, covariance = True, estimate.pose, TAILS**2 * estimate.covariance
        belief = belief_in(estimate)
        if found is not None:
            found, clear = firmest(found, self._sight, pixels, self._habits)
            pose, covariance, belief = found.pose, found.covariance, found.belief(self._rivals.ambiguity)
        clear = clear and (found is None or turn_is_seen(found, self.model))
        state: State = "sure" if believed and clear and is_exact(pose, covariance) else "unsure"
        self._motion = Motion.at_rest(pose, covariance, self._sight.model.middle)
        self._held(pose, believed)
        if believed:
            self._usual.meets(pixels, pose)
            self._usual.believed(quality(estimate.support), None)
        return state, pose, told_covariance(covariance, belief), estimate.support.shares

    def _judged(self, estimate: Estimate, fitted: Found | None) -> bool:
        """Whether what a search found is believed but for look-alikes, after what those before it found."""
        told = found_belief(estimate, fitted)
        if estimate.pose is None or told < HELD:
            return False
        if is_elsewhere(estimate.pose, self._around, self._sight.model):
            self._against = 0
        like = self._is_like_before(estimate)
        if told * (1.0 + estimate.ambiguity) >= SURE * (1.0 + self._rivals.unasked) and like:
            self._against = max(self._against - 1, 0)
            return self._against == 0
        if told < STAYS or not like:
            self._against = min(self._against + 1, MOST_AGAINST)
        return False

    def _is_like_before(self, estimate: Estimate) -> bool:
        """Whether a searched pose is seen as well as the target was; a wider search meets more like it."""
        support = estimate.support
        if support is None or quality(support) < LIKE_BEFORE * self._usual.quality:
            return False
        return self._misses == 0 or is_whole(support)

    def _estimate(self, pixels: Pixels, widened: float) -> Estimate:
        search = Search(self._sight, self._settings, pixels)
        found = search.around(self._trusted if self._misses % 2 else self._around, widened)
        self._vain = 0 if found.score >= SURE and self._is_like_before(found) else self._vain + 1
        if not everywhere_is_due(self._vain, self._misses > 0):
            return found
        both = (found, search.anywhere(self._trusted) or found)
        return max(both, key=lambda one: (self._is_like_before(one), one.score))
