"""`python -m vision_server calibrate`: a camera file from images of a chessboard; such a board to print."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

from bridge.command_line import number, output_file
from bridge.errors import BadInput
from vision_server.commands.files import write_file, write_picture
from vision_server.commands.options import check_outputs, picture_file, warn

GOOD_RMS_PX = 0.5  # of a sharp board and a lens that the model fits; beyond, poses are as wrong
GOOD_FOCAL_SD = 0.005  # of the focal length, which the range is off by


def add_options(parser: ArgumentParser) -> None:
    """Options of the command."""
    parser.description = f"{parser.description} Exit status: 0 written, 2 bad input."
    parser.add_argument(
        "images", metavar="IMAGE", nargs="*", type=Path, help="Images of the board, each from another side."
    )
    parser.add_argument(
        "--corners",
        default="9x6",
        metavar="CxR",
        help="Inner corners of the board, where four squares meet (default: %(default)s).",
    )
    parser.add_argument("--out", type=output_file, metavar="TOML", help="Camera file to write.")
    parser.add_argument(
        "--board", type=picture_file, metavar="PNG", help="Write a board to print, at 300 dots an inch."
    )
    parser.add_argument(
        "--square-mm",
        type=number(1.0, 500.0),
        default=25.0,
        metavar="MM",
        help="Side of its squares (default: %(default)g).",
    )


def run(options: Namespace) -> None:
    """Calibrate, or draw."""
    check_outputs(options, ["images"], ["out", "board"])
    corners = _counted(options.corners)
    if options.board is not None:
        _draw(options, corners)
    if options.images or options.board is None:
        _calibrate(options, corners)


def _counted(text: str) -> tuple[int, int]:
    words = text.lower().split("x")
    if len(words) != 2 or not all(word.isdigit() and 3 <= int(word) <= 50 for word in words):
        raise BadInput(f"--corners: {text!r} is not like 9x6.", "Count the inner corners along both sides.")
    columns, rows = map(int, words)
    return columns, rows


def _draw(options: Namespace, corners: tuple[int, int]) -> None:
    from vision_server.calibration import drawn_board

    write_picture(options.board, drawn_board(corners, options.square_mm))
    print(f"{options.board}: print it at 300 dots an inch, and glue it onto something flat")


def _calibrate(options: Namespace, corners: tuple[int, int]) -> None:
    from stack.tables import toml_text
    from vision_server.calibration import calibrated
    from vision_server.channels.image_files import read_grey

    if not options.images or options.out is None:
        raise BadInput(
            "Images of the board and --out TOML are needed.", "Or --board PNG, for a board to print."
        )
    found = calibrated({str(path): read_grey(path) for path in options.images}, corners)
    for name in found.missed:
        warn(f"no whole board in {name}: left out")
    if found.rms_px > GOOD_RMS_PX:
        warn(f"{found.rms_px:.2f} px is much: is the board flat, are the images sharp?")
    if found.focal_sd > GOOD_FOCAL_SD:
        warn(
            f"the focal length is known to {100 * found.focal_sd:.1f} % only, and every range with it: take "
            "more images, with the board tilted by 30 to 45 degrees and filling the frame"
        )
    write_file(options.out, toml_text({"camera": found.camera}).encode())
    print(
        f"{options.out}: {len(found.seen)} boards, {found.rms_px:.2f} px RMS, "
        f"focal length {found.camera['fx']:.1f} px to {100 * found.focal_sd:.2f} %"
    )
