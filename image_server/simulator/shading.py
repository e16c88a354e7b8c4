"""Radiance of surface points under each light: Lambert and GGX microfacets, as a compiled kernel.

Walter et al., "Microfacet Models for Refraction through Rough Surfaces" (2007), eqs. 33–34 (GGX distribution
and shadowing); Schlick (1994) for Fresnel. Radiances are those of a white Lambert surface turned to the light
times (albedo + pi · specular BRDF) · cos, so pi never appears in the lights' strengths.
"""

import math

import numpy as np
from numpy.typing import NDArray

from image_server.simulator.beam import intensity
from image_server.simulator.sky import light_from, mirrored
from image_server.simulator.texture import ALPHA, CRINKLE, SPECULAR, albedo, crinkled
from numerics.kernels import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LEAST_MIRRORED = 1e-3  # share of the light; less is not worth the time
SUBPIXEL = 0.25  # the texture is averaged at 2×2 places this far from the pixel's centre


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


@kernel(nogil=True)
def shade(
    triangle: NDArray[np.int32],
    direction: NDArray[np.float32],
    distance: NDArray[np.float32],
    reach: NDArray[np.float32],
    pixel: Floats,
    normals: Floats,
    face: Ints,
    surfaces: Floats,
    axes: Floats,
    part: Ints,
    rotations: Floats,
    translations: Floats,
    lights: Floats,
    aims: Floats,
    beams: Floats,
    light_strength: float,
    sun: Floats,
    sun_strength: float,
    sun_radius: float,
    sky: Floats,
    even: float,
    earth: Floats,
    earth_distance: float,
    earth_strength: float,
) -> NDArray[np.float32]:
    """Radiance of N samples under each light and the sun.

    Parameters
    ----------
    triangle : (N,) int32, the triangle that each ray from the camera hits.
    direction, distance : (N, 3) and (N,) float32; the point is their product, metres, camera frame.
    reach : (N, L + 1) float32, share of each light that gets to the point; last the mean cosine of what
        gets there of the sun's disc, 0 for what does not.
    pixel : (2,) size of a pixel at unit distance; (0, 0) takes the texture at the point alone.
    normals, face, surfaces, axes, part, rotations, translations : the scene (`image_server.simulator.scene`).
    lights : (L, 3) positions, camera frame, metres.
    aims, beams : (L, 3) unit vectors and (L, ROWS) tables of the lights' beams (`beam.beam_table`).
    light_strength : radiance of a white surface turned to a light 1 m away, in the middle of its beam.
    sun, sun_strength : unit vector towards the sun, and radiance of a white surface turned to it.
    sun_radius : half the sun's angular diameter, rad; a disc of radius r widens a mirrored sun as if alpha²
        were larger by r²/8 (the variance of the half vectors, times 2).
    sky : (9,) light of everything else (`sky.irradiance`).
    even, earth, earth_distance, earth_strength : the same as faces mirror it (`sky.mirrored`).

    Returns
    -------
    (N, L + 1) float32.
    """
    count, channels = reach.shape
    out = np.zeros((count, channels), np.float32)
    n, v, p, local = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    slope_there = np.empty(3)
    places = 1 if pixel[0] == 0.0 else 4
    for i in range(count):
        t = triangle[i]
        f = face[t]
        s = surfaces[f]
        frame = axes[f]
        r, shift = rotations[part[f]], translations[part[f]]
        length = 0.0
        towards = 0.0
        for k in range(3):
            v[k] = -direction[i, k]
            length += v[k] * v[k]
            p[k] = direction[i, k] * distance[i]
            n[k] = normals[t, k]
            towards += n[k] * v[k]
        length = math.sqrt(length)
        side = 1.0 if towards >= 0 else -1.0
        level = 0.0
        for k in range(3):
            n[k] *= side
            v[k] /= length
            level += n[k] * p[k]
        scattered = 0.0
        for place in range(places):
            dx, dy, dz = direction[i, 0], direction[i, 1], direction[i, 2]
            ray = distance[i]
            if places > 1:
                dx += pixel[0] * SUBPIXEL * (1 if place % 2 else -1)
                dy += pixel[1] * SUBPIXEL * (1 if place > 1 else -1)
                slope = n[0] * dx + n[1] * dy + n[2] * dz
                if slope < -1e-6:
                    ray = min(max(level / slope, 0.5 * distance[i]), 2.0 * distance[i])
            x, y, z = dx * ray - shift[0], dy * ray - shift[1], dz * ray - shift[2]
            for k in range(3):
                local[k] = r[0, k] * x + r[1, k] * y + r[2, k] * z
            u = w = 0.0
            for k in range(3):
                away = local[k] - frame[k]
                u += away * frame[3 + k]
                w += away * frame[6 + k]
            scattered += albedo(s, local[0], local[1], local[2], u, w)
        scattered /= places
        share = reach[i, channels - 1]
        if s[CRINKLE] > 0.0:
            flat = n[0] * sun[0] + n[1] * sun[1] + n[2] * sun[2]
            crinkled(s, local[0], local[1], local[2], slope_there)
            _lean(n, r, slope_there)
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
                out[i, c] = value * reach[i, c] * light_strength / square
        value = scattered * light_from(sky, n[0], n[1], n[2])
        n_v = max(n[0] * v[0] + n[1] * v[1] + n[2] * v[2], 1e-4)
        fresnel = s[SPECULAR] + (1.0 - s[SPECULAR]) * (1.0 - n_v) ** 5
        if fresnel > LEAST_MIRRORED:
            mx, my, mz = 2 * n_v * n[0] - v[0], 2 * n_v * n[1] - v[1], 2 * n_v * n[2] - v[2]
            value += fresnel * mirrored(
                mx, my, mz, s[ALPHA], even, earth, earth_distance, sun, earth_strength
            )
        if share > 0:
            wide = math.sqrt(s[ALPHA] * s[ALPHA] + sun_radius * sun_radius / 8.0)
            bright = _brightness(n, v, sun[0], sun[1], sun[2], scattered, wide, s[SPECULAR])
            value += share * sun_strength * bright
        out[i, channels - 1] = value
    return out
