"""Materials: how each face of a target looks, from `targets/NAME.toml` beside the model."""

from pathlib import Path
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from bridge.errors import BadInput
from stack.tables import Table, as_table, check_direction, read_toml

Texture = Literal["plain", "noise", "veins", "panels", "lines", "checker"]
TEXTURES: tuple[Texture, ...] = ("plain", "noise", "veins", "panels", "lines", "checker")
"""Order of the texture numbers that the kernel knows."""

Positive = Annotated[float, Meta(gt=0)]
Fraction = Annotated[float, Meta(ge=0, le=1)]


class Material(Table, frozen=True):
    """How a face looks.

    Attributes
    ----------
    albedo
        Share of light that is scattered evenly (Lambert), before texture.
    texture
        `plain`, `noise` (clouds), `veins` (a dark net), `panels` (solar cells), `lines` (printed lines
        parallel to the face's sides) or `checker`.
    size_m
        Length of one cloud, vein, cell or line distance.
    contrast
        1 - darkest / brightest albedo of the texture.
    grain
        Contrast of fine noise over everything.
    specular
        Reflectance at normal incidence (Fresnel): 0.04 plastic or paint, 0.5–0.9 metal.
    roughness
        Of the microfacets (GGX, alpha = roughness²): 0.1 mirror-like, 0.6 dull.
    crinkle
        Slope (standard deviation) of folds as long as `size_m`, as in foil; 0 is flat.
    """

    albedo: Fraction = 0.5
    texture: Texture = "noise"
    size_m: Positive = 0.02
    contrast: Fraction = 0.4
    grain: Fraction = 0.05
    specular: Fraction = 0.04
    roughness: Annotated[float, Meta(ge=0.05, le=1)] = 0.5
    crinkle: Fraction = 0.0


class MaterialChanges(Table, frozen=True):
    """The keys of a material that something else than its own table sets; None keeps it."""

    albedo: Fraction | None = None
    texture: Texture | None = None
    size_m: Positive | None = None
    contrast: Fraction | None = None
    grain: Fraction | None = None
    specular: Fraction | None = None
    roughness: Annotated[float, Meta(ge=0.05, le=1)] | None = None
    crinkle: Fraction | None = None

    def applied_to(self, material: Material) -> Material:
        """The material with these keys changed."""
        values = {name: getattr(self, name) for name in MaterialChanges.__struct_fields__}
        return msgspec.structs.replace(material, **{k: v for k, v in values.items() if v is not None})


class FaceMaterial(MaterialChanges, frozen=True, kw_only=True):
    """One of `[[faces]]`: changes for some faces, numbered from 0 as in the model file."""

    faces: Annotated[tuple[Annotated[int, Meta(ge=0)], ...], Meta(min_length=1)]


class Appearance(Table, frozen=True):
    """`targets/NAME.toml`.

    Attributes
    ----------
    front
        Direction (target frame) from which the target is approached.
    material
        Of every face that no `[[faces]]` changes.
    """

    front: tuple[float, float, float] = (0.0, 0.0, -1.0)
    material: Material = Material(texture="veins", size_m=0.02, contrast=0.5)
    faces: tuple[FaceMaterial, ...] = ()

    def material_of(self, face: int) -> Material:
        """Material of one face; later `[[faces]]` win."""
        material = self.material
        for table in self.faces:
            if face in table.faces:
                material = table.applied_to(material)
        return material


def load_appearance(model: Path, face_count: int) -> Appearance:
    """Appearance of a model: the TOML file of the same name beside it, or the default.

    Raises
    ------
    BadInput : a key or value that cannot be used, or a face that the model does not have.
    """
    file = model.with_suffix(".toml")
    if not file.is_file():
        return Appearance()
    appearance = as_table(read_toml(file, "appearance"), Appearance, file)
    for table in appearance.faces:
        if max(table.faces) >= face_count:
            raise BadInput(
                f"{file}: [[faces]] names face {max(table.faces)}, but {model.name} has {face_count} faces.",
                f"Allowed: 0 to {face_count - 1}.",
            )
    check_direction(appearance.front, "front", file, "Give the direction the target is approached from.")
    return appearance
