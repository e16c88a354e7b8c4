"""Folders of CURVE keys: a pair for each program, so that servers may be reached over a network.

`NAME.key` holds a public key, which all may know; `NAME.key_secret` the pair, which stays with its program.
"""

import os
import stat
from pathlib import Path

from bridge.endpoints import CurveClient, CurveServer
from bridge.errors import BadInput

PROGRAMS = ("image_server", "vision_server", "controller")
MAKE_HINT = "Make them with: python -m bridge keys DIR, and copy DIR to each machine."


def make_keys(folder: Path) -> list[Path]:
    """Make a pair of keys for each program; the folder must be new or empty.

    Returns
    -------
    The files written.

    Raises
    ------
    BadInput : the folder has something in it, or cannot be written.
    """
    from zmq.auth import create_certificates  # with much else: only where there are keys

    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise BadInput(f"{folder} is not empty.", "Give a new folder: keys in use are never overwritten.")
        made: list[Path] = []
        for name in PROGRAMS:
            public, secret = map(Path, create_certificates(folder, name))
            secret.chmod(stat.S_IRUSR | stat.S_IWUSR)
            made += [public, secret]
    except OSError as error:
        raise BadInput(
            f"Cannot write keys into {folder}: {error.strerror}.", "Give another folder."
        ) from None
    return made


def server_keys(folder: Path | None, name: str) -> CurveServer | None:
    """Keys of a server, which every other program of the folder may call; None for no folder.

    Raises
    ------
    BadInput : keys that are missing, or cannot be read.
    """
    if folder is None:
        return None
    public, secret = _pair(folder, name)
    others = [
        _public(folder, other) for other in PROGRAMS if other != name and _file(folder, other).is_file()
    ]
    return CurveServer(public, secret, frozenset(others))


def client_keys(folder: Path | None, name: str, server: str) -> CurveClient | None:
    """Keys of a program that calls a server; None for no folder.

    Raises
    ------
    BadInput : keys that are missing, or cannot be read.
    """
    if folder is None:
        return None
    return CurveClient(*_pair(folder, name), _public(folder, server))


def _file(folder: Path, name: str, ending: str = ".key") -> Path:
    return folder / f"{name}{ending}"


def _public(folder: Path, name: str) -> str:
    return _read(_file(folder, name))[0]


def _pair(folder: Path, name: str) -> tuple[str, str]:
    file = _file(folder, name, ".key_secret")
    public, secret = _read(file)
    if secret is None:
        raise BadInput(f"{file} holds no secret key.", MAKE_HINT)
    if os.stat(file).st_mode & (stat.S_IRWXG | stat.S_IRWXO):
        raise BadInput(f"Others can read {file}.", f"It is a secret: chmod 600 {file}")
    return public, secret


def _read(file: Path) -> tuple[str, str | None]:
    from zmq.auth import load_certificate

    try:
        public, secret = load_certificate(file)
        return public.decode("ascii"), None if secret is None else secret.decode("ascii")
    except OSError as error:
        raise BadInput(f"No key in {file}: {error.strerror or 'it is not there'}.", MAKE_HINT) from None
    except ValueError:
        raise BadInput(f"No key in {file}: it is not a certificate.", MAKE_HINT) from None
