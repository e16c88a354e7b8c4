"""`calibrate`: write a camera file for a V4L2 camera."""

from pathlib import Path
from typing import Annotated

from bridge.errors import BadInput
from image_server.command_line import Argument, Option
from image_server.commands.hardware import CAMERA
from image_server.commands.serving import plain_errors


def calibrate(
    camera: Annotated[str, CAMERA],
    out: Annotated[Path, Argument(metavar="OUT.toml", help="Camera file to write.")],
    pixel_format: Annotated[str | None, Option(help="GREY, Y16, YUYV or MJPG.")] = None,
    width: Annotated[int | None, Option(min=1)] = None,
    height: Annotated[int | None, Option(min=1)] = None,
    frame_rate: Annotated[float | None, Option(min=0.01)] = None,
    widest_aperture: Annotated[
        float | None,
        Option(min=0.1, help="f-number of the open iris, where it has a control."),
    ] = None,
    focal_length: Annotated[
        list[str] | None,
        Option(metavar="MM:VALUE", help="Focal length of a value of zoom_absolute; repeatable."),
    ] = None,
    focus: Annotated[
        list[str] | None,
        Option(metavar="M:VALUE", help="Focus distance of a value of focus_absolute; repeatable."),
    ] = None,
) -> None:
    """Measure a camera in front of a steadily lit scene, and write its camera file."""
    with plain_errors():
        import msgspec

        from image_server.v4l2.calibrate import calibrate as measured
        from image_server.v4l2.camera import V4L2Camera
        from image_server.v4l2.camera_file import FormatTable, load_camera_file
        from stack.tables import toml_text

        if out.exists():
            raise BadInput(f"{out} is there already.", "Give another name, or remove it.")
        file = load_camera_file(camera)
        asked = FormatTable(pixel_format=pixel_format, width=width, height=height, frame_rate=frame_rate)
        if asked != FormatTable():
            file = msgspec.structs.replace(file, format=asked)
        opened = V4L2Camera(file)
        try:
            found = measured(
                opened,
                widest_aperture,
                _steps("--focal-length", focal_length),
                _steps("--focus", focus),
            )
            size = opened.size
        finally:
            opened.close()
        shape = msgspec.structs.replace(found.file.format, width=size[0], height=size[1])
        text = toml_text(msgspec.to_builtins(msgspec.structs.replace(found.file, format=shape)))
        try:
            out.write_text(text, encoding="utf-8")
        except OSError as error:
            raise BadInput(f"Cannot write {out}: {error.strerror}.", "Give another name.") from None
        for note in found.notes:
            print(note)
        print(f"{out} written")


def _steps(option: str, given: list[str] | None) -> dict[float, int]:
    steps = {}
    for text in given or []:
        number, _, value = text.partition(":")
        try:
            steps[float(number)] = int(value)
        except ValueError:
            raise BadInput(f"{option}: {text!r} is not NUMBER:VALUE.", "For example 16:100") from None
    return steps
