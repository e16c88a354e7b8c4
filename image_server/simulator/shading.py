"""Radiance of surface points under each light: Lambert and GGX microfacets, as a compiled kernel.

Walter et al., "Microfacet Models for Refraction through Rough Surfaces" (2007), eqs. 33–34 (GGX distribution
and shadowing); Schlick (1994) for Fresnel. Radiances are those of a white Lambert surface turned to the light
times (albedo + pi · specular BRDF) · cos, so pi never appears in the lights' strengths.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from image_server.simulator.light import LIGHT_STRENGTH, Illumination, intensity
from image_server.simulator.scene import Scene
from image_server.simulator.sky import light_from, mirrored
from image_server.simulator.texture import ALPHA, CRINKLE, SPECULAR, albedo, crinkled
from numerics.arrays import Field, Floats
from numerics.kernels import kernel

LEAST_MIRRORED = 1e-3  # share of the light; less is not worth the time
SUBPIXEL = 0.25  # the texture is averaged at 2×2 places this far from the pixel's centre


class SurfaceSamples(NamedTuple):
    """Points that are seen, and what light gets there.

    Attributes
    ----------
    triangle : (N,) int32, the triangle that each ray from the camera hits.
    direction, distance : (N, 3) and (N,) float32; the point is their product, metres, camera frame.
    reach : (N, L + 1) float32, share of each light that gets to the point; last the mean cosine of what
        gets there of the sun's disc, 0 for what does not.
    """

    triangle: NDArray[np.int32]
    direction: Field
    distance: Field
    reach: Field


@kernel()
def microfacets(n_l: float, n_v: float, n_h: float, v_h: float, alpha: float, reflectance: float) -> float:
    """pi times the GGX BRDF, from cosines between normal n, light l, view v and half vector h."""
    a2 = alpha * alpha
    d = n_h * n_h * (a2 - 1.0) + 1.0
    distribution = a2 / (d * d)
    shadow_l = 2.0 * n_l / (n_l + math.sqrt(a2 + (1.0 - a2) * n_l * n_l))
    shadow_v = 2.0 * n_v / (n_v + math.sqrt(a2 + (1.0 - a2) * n_v * n_v))
    fresnel = reflectance + (1.0 - reflectance) * (1.0 - v_h) ** 5
    return distribution * shadow_l * shadow_v * fresnel / (4.0 * n_l * n_v)


@kernel()
def _reflected(
    n: Floats, v: Floats, lx: float, ly: float, lz: float, scattered: float, alpha: float, reflectance: float
) -> float:
    """Radiance towards v per unit of light from the unit vector l, 0 from behind."""
    n_l: float = n[0] * lx + n[1] * ly + n[2] * lz
    if n_l <= 0.0:
        return 0.0
    return n_l * _brightness(n, v, lx, ly, lz, scattered, alpha, reflectance)


@kernel()
def _brightness(
    n: Floats, v: Floats, lx: float, ly: float, lz: float, scattered: float, alpha: float, reflectance: float
) -> float:
    """The same for light that falls on the face: without the cosine."""
    n_l = max(n[0] * lx + n[1] * ly + n[2] * lz, 1e-4)
    n_v = max(n[0] * v[0] + n[1] * v[1] + n[2] * v[2], 1e-4)
    hx, hy, hz = lx + v[0], ly + v[1], lz + v[2]
    length = math.sqrt(hx * hx + hy * hy + hz * hz)
    if length < 1e-9:
        return scattered
    n_h = (n[0] * hx + n[1] * hy + n[2] * hz) / length
    v_h = (v[0] * hx + v[1] * hy + v[2] * hz) / length
    out: float = scattered + microfacets(n_l, n_v, n_h, v_h, alpha, reflectance)
    return out


@kernel()
def _lean(n: Floats, rotation: Floats, slope: Floats) -> None:
    """Lean the normal n (3,), in place, against a slope (3,) that is given in the part's frame."""
    x = rotation[0, 0] * slope[0] + rotation[0, 1] * slope[1] + rotation[0, 2] * slope[2]
    y = rotation[1, 0] * slope[0] + rotation[1, 1] * slope[1] + rotation[1, 2] * slope[2]
    z = rotation[2, 0] * slope[0] + rotation[2, 1] * slope[1] + rotation[2, 2] * slope[2]
    along = x * n[0] + y * n[1] + z * n[2]
    x, y, z = n[0] - x + along * n[0], n[1] - y + along * n[1], n[2] - z + along * n[2]
    length = math.sqrt(x * x + y * y + z * z)
    n[0], n[1], n[2] = x / length, y / length, z / length


@kernel(inline="always")
def _set_out(direction: Field, distance: float, normal: Floats, n: Floats, v: Floats, p: Floats) -> None:
    """Write a sample's unit normal on the camera's side, unit vector to the camera, and point (3,)."""
    length = 0.0
    towards = 0.0
    for k in range(3):
        v[k] = -direction[k]
        length += v[k] * v[k]
        p[k] = direction[k] * distance
        n[k] = normal[k]
        towards += n[k] * v[k]
    length = math.sqrt(length)
    side = 1.0 if towards >= 0 else -1.0
    for k in range(3):
        n[k] *= side
        v[k] /= length


@kernel(inline="always")
def _scattered(
    direction: Field,
    distance: float,
    pixel: Floats,
    n: Floats,
    p: Floats,
    surface: Floats,
    plane: Floats,
    pose: Floats,
) -> tuple[float, float, float, float]:
    """Albedo, averaged over a pixel that has a size; and the last place of it in the part's frame."""
    level = 0.0
    for k in range(3):
        level += n[k] * p[k]
    places = 1 if pixel[0] == 0.0 else 4
    total = a = b = c = 0.0
    for place in range(places):
        dx, dy, dz = direction[0], direction[1], direction[2]
        ray = distance
        if places > 1:
            dx += pixel[0] * SUBPIXEL * (1 if place % 2 else -1)
            dy += pixel[1] * SUBPIXEL * (1 if place > 1 else -1)
            slope = n[0] * dx + n[1] * dy + n[2] * dz
            if slope < -1e-6:
                ray = min(max(level / slope, 0.5 * distance), 2.0 * distance)
        x, y, z = dx * ray - pose[3, 0], dy * ray - pose[3, 1], dz * ray - pose[3, 2]
        a = pose[0, 0] * x + pose[1, 0] * y + pose[2, 0] * z
        b = pose[0, 1] * x + pose[1, 1] * y + pose[2, 1] * z
        c = pose[0, 2] * x + pose[1, 2] * y + pose[2, 2] * z
        da, db, dc = a - plane[0], b - plane[1], c - plane[2]
        u = da * plane[3] + db * plane[4] + dc * plane[5]
        w = da * plane[6] + db * plane[7] + dc * plane[8]
        total += albedo(surface, a, b, c, u, w)
    return total / places, a, b, c


@kernel()
def shade(
    samples: SurfaceSamples, pixel: Floats, scene: Scene, light: Illumination, even_light: Floats
) -> Field:
    """Radiance (N, L + 1) float32 of samples under each light, and under the sun with the sky.

    Parameters
    ----------
    pixel : (2,) size of a pixel at unit distance; (0, 0) takes the texture at the point alone.
    even_light : (9,) light of the sky (`sky.irradiance`).

    The sun's disc of radius r widens a mirrored sun as if alpha² were larger by r²/8 (the variance of the
    half vectors, times 2).
    """
    triangle, direction, distance, reach = samples
    lights, aims, beams, sky = light
    normals, faces, surfaces, planes, parts, poses = (
        scene.normals, scene.face, scene.surfaces, scene.axes, scene.part, scene.poses,
    )  # fmt: skip
    sun, sun_strength, sun_radius = sky.sun, sky.sun_strength, sky.sun_radius_rad
    count, channels = reach.shape
    out = np.zeros((count, channels), np.float32)
    n, v, p, slope = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for i in range(count):
        face = faces[triangle[i]]
        s = surfaces[face]
        pose = poses[parts[face]]
        ray = direction[i]
        _set_out(ray, distance[i], normals[triangle[i]], n, v, p)
        scattered, x, y, z = _scattered(ray, distance[i], pixel, n, p, s, planes[face], pose)
        share = reach[i, channels - 1]
        if s[CRINKLE] > 0.0:
            flat = n[0] * sun[0] + n[1] * sun[1] + n[2] * sun[2]
            crinkled(s, x, y, z, slope)
            _lean(n, pose, slope)
            bent = n[0] * sun[0] + n[1] * sun[1] + n[2] * sun[2]
            share *= max(bent, 0.0) / max(flat, 1e-2)
        for c in range(channels - 1):
            if reach[i, c] > 0:
                lx, ly, lz = lights[c, 0] - p[0], lights[c, 1] - p[1], lights[c, 2] - p[2]
                square = max(lx * lx + ly * ly + lz * lz, 1e-6)
                one = 1.0 / math.sqrt(square)
                lx, ly, lz = lx * one, ly * one, lz * one
                value = _reflected(n, v, lx, ly, lz, scattered, s[ALPHA], s[SPECULAR])
                value *= intensity(beams[c], -(lx * aims[c, 0] + ly * aims[c, 1] + lz * aims[c, 2]))
                out[i, c] = value * reach[i, c] * LIGHT_STRENGTH / square
        value = scattered * light_from(even_light, n[0], n[1], n[2])
        n_v = max(n[0] * v[0] + n[1] * v[1] + n[2] * v[2], 1e-4)
        fresnel = s[SPECULAR] + (1.0 - s[SPECULAR]) * (1.0 - n_v) ** 5
        if fresnel > LEAST_MIRRORED:
            mx, my, mz = 2 * n_v * n[0] - v[0], 2 * n_v * n[1] - v[1], 2 * n_v * n[2] - v[2]
            value += fresnel * mirrored(mx, my, mz, s[ALPHA], sky)
        if share > 0:
            wide = math.sqrt(s[ALPHA] * s[ALPHA] + sun_radius * sun_radius / 8.0)
            bright = _brightness(n, v, sun[0], sun[1], sun[2], scattered, wide, s[SPECULAR])
            value += share * sun_strength * bright
        out[i, channels - 1] = value
    return out
