"""The text of a model's file, in the encodings that programs write."""

import codecs
from pathlib import Path


def text_of(path: Path) -> str:
    """A file's text, in UTF-8 or, as PowerShell writes it, in UTF-16; what is neither becomes U+FFFD.

    Raises
    ------
    OSError : it cannot be read.
    """
    with path.open("rb") as file:
        wide = file.read(2) in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
    return path.read_text(encoding="utf-16" if wide else "utf-8-sig", errors="replace")
