"""The target's pose in every frame: followed while it can be, said to be lost when it cannot, found again.

A frame is looked at in this order, until a look suffices:

1. *Near* the pose that the motion foresees (`following.Sight.near`). That suffices after a frame that was
   followed surely, if the motion foresees the pose to within this look's reach, and what is seen is believed
   and as in other frames in this light (`usual`).
2. *Farther*, some 30 px around the foreseen pose, and the last one unless what is near is believed and dim
   (`Sight.far`), and turned to and fro where the motion foresees less than a near look reaches
   (`Sight.turned`). The likeliest of the believed poses is taken (`following.likeliest`), else the best that
   is HELD, or has whole lines, beside an occluder.
3. *Around* the last pose, as a session's estimate does it (`searching`), if there is no such pose, or if it
   is not believed and LOOKED_AT_ANEW before it were not.
4. *Everywhere*, after so many searches in vain (`searching.everywhere_is_due`).

From 2 on, `turning` leaves out what is turned farther than targets turn. What is known then is in `history`:

| the frame's pose | is told as | the next frame is looked at |
| --- | --- | --- |
| is followed surely: believed, as the last was, and `acceptance.is_sure` | sure (1) | near, if it suffices |
| is followed and believed, but not surely | unsure | near and farther |
| is followed and doubted | unsure | the same; around when that has lasted |
| is found by a search that believes it | sure (1) if exact | near and farther |
| is found by a search that doubts it | unsure | the same; none is believed until a search is |
| is not there | lost | near and farther for LONGEST_WITHOUT_S; around, wider each time |

(1) Unless a narrow face (`narrow`) or an unseen turn (`round_parts`) leaves another pose as likely.
"""

from __future__ import annotations

import time
from dataclasses import replace

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Floats
from vision_server.channels.depth import Pixels
from vision_server.channels.tone import KNOWN_TONE_SD_PX
from vision_server.matching.match import Anywhere
from vision_server.pipeline import PipelineSettings
from vision_server.tracking import acceptance
from vision_server.tracking.clock import Clock
from vision_server.tracking.fitting import Habits
from vision_server.tracking.following import NEAR_REACHES_PX, Foreseen, Found, Sight, likeliest
from vision_server.tracking.frame import Tone, check_size
from vision_server.tracking.history import History
from vision_server.tracking.motion import Innovation, Motion
from vision_server.tracking.narrow import firmest
from vision_server.tracking.rivals import Rivals
from vision_server.tracking.round_parts import RoundTurns
from vision_server.tracking.searching import Searches
from vision_server.tracking.strain import Strain
from vision_server.tracking.tracked import State, Tracked
from vision_server.tracking.turning import Turning
from vision_server.tracking.usual import Usual
from vision_server.trust.judgement import Estimate
from vision_server.trust.probability import ERROR_OVER_SD, quality

Seen = tuple[State, Pose | None, Floats | None, dict[int, float] | None]
"""State, pose, covariance, and the share of each visible line that is seen: as in `Tracked`."""

# Squared innovations: an honest filter's are 6 on average, and 1 % and 1e-6 of them are larger than these.
EXPECTED_CHI2, SURPRISING_CHI2 = 16.8, 38.3
# By hand. A frame with less of the quality that is usual in its light is sure only where its probability is
# SURE; after so many frames in a row that are not believed a search is made; and after so long without a pose
# the velocity says nothing any more.
SURE_QUALITY, LOOKED_AT_ANEW, LONGEST_WITHOUT_S = 0.6, 5, 0.5
# By hand: where frames are sure, edges outside of the target are asked about in each such frame.
OUTER_ASKED_FRAMES = 4


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
        if edge_radius_m is not None:
            model = replace(model, edge_radius_m=edge_radius_m)
        self.model, self.camera = model, camera
        self._sight, self._usual = Sight(model, camera, Tone.of(gamma, tone_sd_px)), Usual(model, camera)
        self._history = History(seed_pose, seed_pose)
        settings = PipelineSettings(seed=seed, tone_sd_px=tone_sd_px, coarse=False)  # a frame has little time
        self._searches = Searches(self._sight, settings, self._history, self._usual)
        self._motion: Motion | None = None
        self._habits, self._turning = Habits.of(model, edge_radius_m), Turning(model)
        self._rivals, self._strain, self._round = Rivals(), Strain(), RoundTurns(model)
        self._clock, self._frame = Clock(), -1

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
        check_size(pixels, self.camera, self._frame + 1)  # a frame that is refused moves nothing on
        self._frame += 1
        note, seconds = self._clock.passed(pixels, time_s)
        self._turning.passed(seconds)
        state, pose, covariance, support = self._seen(pixels, seconds)
        if state == "sure" and pose is not None:
            self._turning.seen(pose)
        return Tracked(self._frame, state, pose, covariance, time.process_time() - began, note, support)

    def _seen(self, pixels: Pixels, seconds: float) -> Seen:
        found, held = None, False
        self._history.without_s += seconds
        if self._motion is not None:
            self._motion = self._motion.after(seconds)
            found = self._followed(pixels, self._motion)
        if found is not None:
            held = found.belief(0.0) >= acceptance.HELD
            if found.belief(0.0) >= acceptance.STAYS:
                self._rivals.weigh(found, lambda pose: self._sight.near(pixels, pose, self._habits))
            if self._history.doubted < LOOKED_AT_ANEW or self._is_believed(found, self._innovation(found)):
                return self._taken(found)
        return self._searched(pixels, found if held else None)

    def _followed(self, pixels: Pixels, expected: Motion) -> Found | None:
        """What a look near the expected pose finds, or one farther around where that does not suffice."""
        start, history = expected.pose(self.model.middle), self._history
        self._usual.meets(pixels, start)
        foreseen = expected.spread_px(self.camera, 0.5 * self.model.diameter) < NEAR_REACHES_PX[0]
        known = None
        if history.softness is not None:
            known = Foreseen(history.softness, outer=self._frame % OUTER_ASKED_FRAMES == 0)
        near = self._sight.near(pixels, start, self._habits, known)
        steady = known is not None and foreseen
        believed = near is not None and steady and self._is_believed(near, self._innovation(near))
        if near is not None and believed and self._usual.shows(near.support):
            return near
        starts = [start] if believed or isinstance(history.last, Anywhere) else [start, history.last]
        candidates = self._sight.far(pixels, starts, self._habits) + ([] if near is None else [near])
        if candidates and not foreseen:
            candidates += self._sight.turned(pixels, candidates, self._habits)
        candidates = [one for one in candidates if self._turning.allows(one.pose)]
        return self._chosen(sorted(candidates, key=lambda one: -one.quality), expected)

    def _chosen(self, candidates: list[Found], expected: Motion) -> Found | None:
        """Of poses, the best seen first, the one that is followed."""
        innovations = [self._innovation(one) for one in candidates]
        both = list(zip(candidates, innovations, strict=True))
        if believed := [one for one, innovation in both if self._is_believed(one, innovation)]:
            return likeliest(believed, expected, self.model.middle)
        held = [one for one in candidates if one.belief(0.0) >= acceptance.HELD]
        if not held and self._history.lost == 0:
            foreseen = [one for one, innovation in both if innovation.squared <= SURPRISING_CHI2]
            held = [one for one in foreseen if acceptance.is_partly_whole(one.support)]
        return held[0] if held else None

    def _innovation(self, found: Found) -> Innovation:
        """Of a pose, against the motion as it is."""
        assert self._motion is not None
        return self._motion.innovation(found.pose, found.covariance, self.model.middle)

    def _is_believed(self, found: Found, innovation: Innovation) -> bool:
        return self._may_be_believed(found) and self._is_likely(found, innovation)

    def _may_be_believed(self, found: Found) -> bool:
        """Whether neither the last search nor frames in light like this one's speak against a pose."""
        return self._history.search_believed and self._usual.is_like_before(found.quality)

    def _is_likely(self, found: Found, innovation: Innovation) -> bool:
        """Whether a pose would be believed in light that usually shows as little."""
        probable = acceptance.is_probable(found, self._rivals, self._history.believed)
        return probable and innovation.squared <= SURPRISING_CHI2

    def _taken(self, found: Found) -> Seen:
        """A pose that was followed is this frame's: the motion goes on from it."""
        assert self._motion is not None
        history = self._history
        found, clear = firmest(found, self._sight, self._habits)
        innovation = self._innovation(found)
        likely = self._is_likely(found, innovation)
        believed = likely and self._may_be_believed(found)
        if innovation.squared <= SURPRISING_CHI2:
            self._motion = self._motion.corrected(innovation)
        else:
            self._motion = Motion.at_rest(found.pose, found.covariance, self.model.middle)
        stays = innovation.squared <= EXPECTED_CHI2 and found.quality >= SURE_QUALITY * self._usual.quality
        steady = believed and (history.believed or self._usual.is_other)
        steady = steady and acceptance.is_sure(found, self._rivals, stays)
        steady = steady and not self._strain.asked(found.is_strained)
        firm = steady and clear
        seen, better = self._round.asked(found, self._habits, self._frame) if firm else (False, None)
        if better is not None:
            return self._turned(better)
        history.told(found.pose, believed)
        if believed:
            self._usual.believed(found.quality, acceptance.whole_lines(found.support) if steady else None)
            self._habits = self._habits.after(found.fit)
        elif likely:
            self._usual.doubted(found.quality)
        else:
            self._usual.forget_doubts()
        lines = found.fit.observation.samples.line
        soft = found.softness.kept(self.model, self.camera, found.pose, lines, history.softness)
        history.softness = soft if steady else None
        state: State = "sure" if firm and seen else "unsure"
        covariance = acceptance.told_covariance(found.covariance, found.belief(self._rivals.ambiguity))
        return state, found.pose, covariance, found.support.shares

    def _turned(self, better: Found) -> Seen:
        """A pose that is turned about an axis of a round part is this frame's: it is followed, not surely."""
        self._motion = Motion.at_rest(better.pose, better.covariance, self.model.middle)
        self._usual.forget_doubts()
        self._history.told(better.pose, believed=False)
        self._history.softness = None
        covariance = acceptance.told_covariance(better.covariance, better.belief(self._rivals.ambiguity))
        return "unsure", better.pose, covariance, better.support.shares

    def _searched(self, pixels: Pixels, followed: Found | None) -> Seen:
        """What a search makes of a frame.

        A pose that was ``followed`` and is not believed stays unless what is found is better.
        """
        self._history.search_begins()
        self._usual.forget_doubts()
        estimate = self._searches.estimate(pixels)
        same = followed is not None and followed.is_at(estimate.pose)
        self._rivals.found(estimate, goes_on=same)
        found, promising = None, self._is_promising(estimate)
        if promising and estimate.pose is not None:  # on whole lines, as every frame is
            found = self._sight.near(pixels, estimate.pose, self._habits)
        found = found if found is not None and found.is_at(estimate.pose) else None
        if followed is not None and (found is None or found.quality <= followed.quality):
            return self._kept(followed, estimate, found)
        return self._adopted(pixels, estimate, found) if promising else self._lost()

    def _kept(self, followed: Found, estimate: Estimate, found: Found | None) -> Seen:
        """The followed pose stays, as a search finds none that is better; what it finds may be this one."""
        history, same = self._history, followed.is_at(estimate.pose)
        belief = acceptance.found_belief(estimate, found)
        stays = same and history.search_believed and belief >= acceptance.STAYS
        believed = stays or (self._searches.believe(estimate, found, self._rivals.unasked) and same)
        history.search_believed = believed
        history.believed = believed and acceptance.are_unlikely(self._rivals)
        return self._taken(followed)

    def _lost(self) -> Seen:
        """There is no pose."""
        self._history.missed()
        self._motion = None if self._history.without_s > LONGEST_WITHOUT_S else self._motion
        return "lost", None, None, None

    def _adopted(self, pixels: Pixels, estimate: Estimate, found: Found | None) -> Seen:
        """The pose that a search found is this frame's, at rest as far as is known."""
        assert estimate.pose is not None and estimate.covariance is not None and estimate.support is not None
        history, far = self._history, not self._turning.allows(estimate.pose)
        if far:  # one witness is not enough: the next search is the second
            self._turning.seen(estimate.pose)
        history.search_believed = self._searches.believe(estimate, found, self._rivals.unasked) and not far
        believed = history.search_believed and acceptance.are_unlikely(self._rivals)
        clear, pose, covariance = True, estimate.pose, ERROR_OVER_SD**2 * estimate.covariance
        belief = acceptance.belief_in(estimate)
        if found is not None:
            found, clear = firmest(found, self._sight, self._habits)
            pose, covariance, belief = found.pose, found.covariance, found.belief(self._rivals.ambiguity)
            clear = clear and self._round.is_seen(found)
        self._motion = Motion.at_rest(pose, covariance, self.model.middle)
        history.told(pose, believed)
        if believed:
            self._usual.meets(pixels, pose)
            self._usual.believed(quality(estimate.support), None)
        state: State = "sure" if believed and clear and acceptance.is_exact(pose, covariance) else "unsure"
        return state, pose, acceptance.told_covariance(covariance, belief), estimate.support.shares

    def _is_promising(self, estimate: Estimate) -> bool:
        """Whether what a search found is likely enough to be followed, and not turned too far for it."""
        likely = estimate.score >= acceptance.HELD or acceptance.is_likely(estimate, self._history.met)
        if estimate.pose is None or not likely:
            return False
        return self._turning.allows(estimate.pose) or self._turning.stands_out(estimate)
