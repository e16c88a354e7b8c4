"""The page on which corners are pointed at, in the model's drawing and in the image, and what it asks."""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any

import cv2
import msgspec
import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from bridge.errors import BadInput
from geometry.camera import Camera
from geometry.model import Model
from geometry.wireframe import visible_runs
from numerics.arrays import Grey
from report.loopback import refused
from vision_server.seeding.corners import corners_of
from vision_server.seeding.pairs import Pairs
from vision_server.seeding.points_pose import PointsPose, pose_of_points, wrong_pair

HERE = Path(__file__).resolve().parent
MOST_BYTES = 100_000  # of one question: a thousand pairs


class Click(msgspec.Struct, forbid_unknown_fields=True):
    """One pair: a corner, by its number in the page's list, and its place in the image, px."""

    corner: int
    at: tuple[float, float]


class SeedView:
    """The page's server, for one image.

    Parameters
    ----------
    grey : (H, W), the image.
    save : writes a pose that was found; what it says is shown. BadInput where it cannot.

    Attributes
    ----------
    token : what the page's address must have; who does not have it sees and does nothing.
    """

    def __init__(
        self, model: Model, camera: Camera, grey: Grey, save: Callable[[PointsPose, Pairs], str]
    ) -> None:
        self._model, self._camera, self._grey, self._save = model, camera, grey, save
        self._corners = model.vertices[corners_of(model)]
        self.token = secrets.token_urlsafe(16)
        self.saved = asyncio.Event()

    def app(self) -> Any:
        """The page as an ASGI application."""
        from starlette.applications import Starlette
        from starlette.routing import Route

        return Starlette(
            routes=[
                Route("/", self._page),
                Route("/image.png", self._image),
                Route("/pose", self._pose, methods=["POST"]),
                Route("/save", self._pose, methods=["POST"]),
            ]
        )

    async def _page(self, request: Any) -> Any:
        from starlette.responses import HTMLResponse

        refusal = refused(request, request.query_params.get("token"), self.token)
        return refusal or HTMLResponse(self._html, headers={"Referrer-Policy": "no-referrer"})

    async def _image(self, request: Any) -> Any:
        from starlette.responses import Response

        refusal = refused(request, request.query_params.get("token"), self.token)
        return refusal or Response(self._png, media_type="image/png")

    async def _pose(self, request: Any) -> Any:
        """The pose of the page's pairs; on `/save` it is written, and the page has done its work."""
        from starlette.responses import JSONResponse, PlainTextResponse

        refusal = refused(request, request.headers.get("x-token"), self.token)
        if refusal is not None:
            return refusal
        saves = request.url.path == "/save"
        try:
            answer = await asyncio.to_thread(self._answer, await _body(request), saves)
        except BadInput as error:
            return PlainTextResponse(f"{error}\n", 409)
        if saves:
            self.saved.set()
        return JSONResponse(answer)

    def _answer(self, body: bytes, saves: bool) -> dict[str, Any]:
        pairs = self._pairs(body)
        found = pose_of_points(pairs, self._model, self._camera, self._grey)
        if saves:
            return {"said": self._save(found, pairs)}
        runs = visible_runs(self._model, self._camera, found.pose)
        return {
            "rotation": found.pose.matrix.tolist(),
            "rms_px": found.rms_px,
            "errors_px": found.errors_px.tolist(),
            "others": len(found.others),
            "wrong": wrong_pair(found, pairs, self._model, self._camera),
            "lines": [np.round(run.points, 2).tolist() for run in runs],
        }

    def _pairs(self, body: bytes) -> Pairs:
        try:
            clicks = msgspec.json.decode(body, type=list[Click])
        except (msgspec.DecodeError, msgspec.ValidationError) as error:
            raise BadInput(f"These are no pairs: {error}.") from error
        if any(not 0 <= click.corner < len(self._corners) for click in clicks):
            raise BadInput("A pair names a corner that the model does not have.")
        pixels = np.array([click.at for click in clicks], dtype=np.float64).reshape(-1, 2)
        return Pairs(pixels, self._corners[[click.corner for click in clicks]].reshape(-1, 3))

    @cached_property
    def _png(self) -> bytes:
        return bytes(cv2.imencode(".png", self._grey)[1].tobytes())

    @cached_property
    def _html(self) -> str:
        model = self._model
        loader = FileSystemLoader(HERE)
        templates = Environment(loader=loader, autoescape=True, undefined=StrictUndefined)
        drawn = {
            "middle": model.middle.tolist(),
            "size": model.diameter,
            "vertices": model.vertices.tolist(),
            "lines": model.lines.tolist(),
            "line_faces": model.line_faces.tolist(),
            "smooth": model.smooth.tolist(),
            "normals": np.round(model.face_normals, 4).tolist(),
            "corners": self._corners.tolist(),
        }
        return templates.get_template("page.html.j2").render(
            name=model.name,
            model=drawn,
            width=self._camera.width,
            height=self._camera.height,
            token=self.token,
            script=Markup((HERE / "page.js").read_text(encoding="utf-8")),
        )


async def _body(request: Any) -> bytes:
    """What a page sent; BadInput where that is too much."""
    body = b""
    async for part in request.stream():
        body += part
        if len(body) > MOST_BYTES:
            raise BadInput("These are too many pairs.")
    return body
