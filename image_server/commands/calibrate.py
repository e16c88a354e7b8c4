"""`calibrate`: write a camera file for a V4L2 camera."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from bridge.command_line import number, output_file, whole_number
from bridge.errors import BadInput
from image_server.commands.options import add_camera


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("out", type=output_file, metavar="OUT.toml", help="Camera file to write.")
    add_camera(parser)
    parser.add_argument("--pixel-format", metavar="NAME", help="GREY, Y16, YUYV or MJPG.")
    usual = "; as the camera has it now when left out."
    parser.add_argument("--width", type=whole_number(1), metavar="PX", help=f"Of the frames, px{usual}")
    parser.add_argument("--height", type=whole_number(1), metavar="PX", help=f"Of the frames, px{usual}")
    parser.add_argument("--frame-rate", type=number(0.01), metavar="N", help=f"Frames a second{usual}")
    parser.add_argument(
        "--widest-aperture",
        metavar="N",
        type=number(0.1),
        help="f-number of the open iris, where it has a control.",
    )
    parser.add_argument(
        "--focal-length",
        action="append",
        default=[],
        metavar="MM:VALUE",
        help="Focal length of a value of zoom_absolute; repeatable.",
    )
    parser.add_argument(
        "--focus",
        action="append",
        default=[],
        metavar="M:VALUE",
        help="Focus distance of a value of focus_absolute; repeatable.",
    )


def run(options: Namespace) -> None:
    """Measure and write."""
    import msgspec

    from image_server.v4l2.calibrate import calibrate as measured
    from image_server.v4l2.camera import V4L2Camera
    from image_server.v4l2.camera_file import FormatTable, load_camera_file
    from stack.tables import toml_text

    if options.out.exists():
        raise BadInput(f"{options.out} is there already.", "Give another name, or remove it.")
    file = load_camera_file(options.camera)
    asked = FormatTable(
        pixel_format=options.pixel_format,
        width=options.width,
        height=options.height,
        frame_rate=options.frame_rate,
    )
    if asked != FormatTable():
        file = msgspec.structs.replace(file, format=asked)
    opened = V4L2Camera(file)
    try:
        found = measured(
            opened,
            options.widest_aperture,
            _steps("--focal-length", options.focal_length),
            _steps("--focus", options.focus),
        )
        size = opened.size
    finally:
        opened.close()
    shape = msgspec.structs.replace(found.file.format, width=size[0], height=size[1])
    text = toml_text(msgspec.to_builtins(msgspec.structs.replace(found.file, format=shape)))
    try:
        options.out.write_text(text, encoding="utf-8")
    except OSError as error:
        raise BadInput(f"Cannot write {options.out}: {error.strerror}.", "Give another name.") from None
    for note in found.notes:
        print(note)
    print(f"{options.out} written")


def _steps(option: str, given: list[str]) -> dict[float, int]:
    steps = {}
    for text in given:
        distance, _, value = text.partition(":")
        try:
            steps[float(distance)] = int(value)
        except ValueError:
            raise BadInput(f"{option}: {text!r} is not NUMBER:VALUE.", "For example 16:100") from None
    return steps
