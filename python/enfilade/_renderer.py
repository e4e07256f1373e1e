"""Rendering of views, into new arrays or the caller's memory."""

from __future__ import annotations

import importlib
import math
import os
from collections.abc import Mapping
from typing import Any, Dict, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from enfilade._arguments import deprecated, whole
from enfilade._core import DatasetFolder, Graphs, Panoramas, ViewArrays, ViewRenderer
from enfilade._errors import ArgumentError
from enfilade._layers import LAYERS, checked_layer, layer_of
from enfilade._simulator import Names, Simulator, _make_again, scan_indices, viewpoint_indices

# The type of an image's values: by format of rgb, and by layer.
_FORMATS = {"rgb8": "uint8", "bgr8": "uint8", "rgba8": "uint8", "planar": "float32",
            "imagenet": "float32"}  # fmt: skip
_TYPES = {"depth": "float32", "semantic": "uint16", "instance": "uint32"}
_NOT_GIVEN: Any = object()
CACHES = ("private", "shared")


def open_panoramas(folder: Union[str, os.PathLike[str]], graphs: Graphs) -> Panoramas:
    """The panoramas of a data folder: its `store`, `scans`, `v1/scans`, `data/v1/scans`, or itself.

    Raises FileError if it is not a folder.
    """
    images, connectivity = DatasetFolder(folder).panorama_places
    return Panoramas(images, connectivity, graphs)


def _panoramas_again(images: Any, connectivity: Any, scans: list[str]) -> Panoramas:
    """For unpickling Panoramas."""
    return Panoramas.of_scans(images, connectivity, scans)


class _Pictures(Dict[str, Any]):
    """Arrays by layer; the key "colour" of earlier releases warns."""

    def __missing__(self, name: str) -> Any:
        if name != "colour":
            raise KeyError(name)
        deprecated("the key 'colour'", "'rgb'")
        return self["rgb"]


class Renderer:
    """Renders batches of views. Use one renderer per thread; rendering releases the GIL.

    Args:
        graphs, panoramas: of the same scans.
        backend: "cpu" (SIMD), "cpu-scalar" (slow, the reference), "gl" (OpenGL without a display),
            "cuda" (an NVIDIA GPU; the CPU's images to the bit).
        threads: for rendering; 0: all cores.
        cache_bytes: size of the cache of decoded faces; a panorama of 512 texels takes 6.4 MB of colour.
        cache: "private", or "shared": faces are also cached in a file in /dev/shm that all renderers of
            this user's processes share. Each face is then decoded once and in memory once.
        shared_bytes: size of that file, whole MiB, the same for all its renderers.
        clamped_edges, eight_bit_depth: as in the old simulator, for features made with it.
        device: an EGL device's index or UUID, for "gl"; a GPU's number, for "cuda"; empty: the first
            that works.
        card_bytes: GPU memory for panoramas, for "cuda"; 0: half of the free memory.

    A pickled or copied renderer has the same settings. Raises ArgumentError for invalid values, or for
    graphs and panoramas of different scans. Raises FileError if the shared file cannot be used, or does
    not fit into /dev/shm.
    """

    def __init__(
        self,
        graphs: Graphs,
        panoramas: Panoramas,
        *,
        backend: str = "cpu",
        threads: int = 0,
        cache_bytes: int = 256 << 20,
        cache: str = "private",
        shared_bytes: int = 1 << 30,
        clamped_edges: bool = False,
        eight_bit_depth: bool = False,
        device: str = "",
        card_bytes: int = 0,
    ) -> None:
        if graphs.scans != panoramas.scans:
            raise ArgumentError("graphs and panoramas are of different scans")
        if cache not in CACHES:
            raise ArgumentError(f"cache '{cache}': one of {', '.join(CACHES)} is wanted")
        shared = whole("shared_bytes", shared_bytes, 2**63 - 1)
        self.graphs, self.panoramas = graphs, panoramas
        self._options = {
            "backend": backend,
            "threads": threads,
            "cache_bytes": cache_bytes,
            "cache": cache,
            "shared_bytes": shared_bytes,
            "clamped_edges": clamped_edges,
            "eight_bit_depth": eight_bit_depth,
            "device": device,
            "card_bytes": card_bytes,
        }
        self._core = ViewRenderer(
            panoramas,
            backend,
            threads,
            whole("cache_bytes", cache_bytes, 2**63 - 1),
            shared if cache == "shared" else 0,
            clamped_edges,
            eight_bit_depth,
            device,
            whole("card_bytes", card_bytes, 2**63 - 1),
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return _make_again, (type(self), self.graphs, self.panoramas, self._options)

    @property
    def description(self) -> str:
        """Back end and device: "cpu (AVX3, 2 threads)", "gl (llvmpipe, OpenGL 4.5)"."""
        return self._core.description

    def render(
        self,
        scans: Names,
        viewpoints: Names,
        headings: ArrayLike,
        elevations: ArrayLike = 0.0,
        *,
        width: int = 640,
        height: int = 480,
        vfov: float = math.radians(60),
        rgb: Optional[str] = "rgb8",
        layers: tuple[str, ...] = (),
        ray_depth: bool = False,
        out: Optional[Mapping[str, Any]] = None,
        stream: Optional[int] = None,
        colour: Optional[str] = _NOT_GIVEN,
    ) -> dict[str, Any]:
        """Renders n views, by names or indices of scans and viewpoints; angles in radians.

        Args:
            rgb: the format of the layer rgb: "rgb8", "bgr8": (n, h, w, 3) uint8; "rgba8": (n, h, w, 4);
                "planar": (n, 3, h, w) float32 in [0, 1]; "imagenet": the same, normalised for
                torchvision's models; None: no rgb.
            layers: further layers, any of "depth" ((n, h, w) float32 metres along the optical axis, 0: no
                reading), "semantic" ((n, h, w) uint16), "instance" ((n, h, w) uint32).
            ray_depth: depth along each pixel's ray instead.
            out: target arrays, by "rgb" and the layers' names: contiguous, writable, of those
                shapes, of any library with DLPack or the buffer protocol (NumPy, torch on the CPU).
                Depth may be uint16 (quarter millimetres), semantic uint8, planar rgb float16.
                Missing arrays are allocated on the CPU. With the back end "cuda", arrays may be in
                its GPU's memory (torch, CuPy); nothing is then copied to the CPU.
            stream: for arrays in GPU memory, the address of a stream
                (torch.cuda.current_stream().cuda_stream). Work is queued in it, and render() returns
                before it is complete. None: the current stream of torch or CuPy; with other libraries
                there is no stream, and the images are complete when render() returns.
            colour: the old name of `rgb`.

        Returns the arrays by layer, including those of `out`. Raises ArgumentError or TypeError for
        invalid arguments; UnknownNameError, FileError, InvalidInput for missing or broken images.
        """
        scan = scan_indices(self.graphs, scans)
        viewpoint = viewpoint_indices(self.graphs, scan, viewpoints)
        n = len(scan)
        views = ViewArrays(
            scan, viewpoint, _angles("headings", headings, n), _angles("elevations", elevations, n)
        )
        return self._draw(views, width, height, vfov, rgb, layers, ray_depth, out, stream, colour)

    def _draw(
        self,
        views: ViewArrays,
        width: int,
        height: int,
        vfov: float,
        rgb: Optional[str] = "rgb8",
        layers: tuple[str, ...] = (),
        ray_depth: bool = False,
        out: Optional[Mapping[str, Any]] = None,
        stream: Optional[int] = None,
        colour: Optional[str] = _NOT_GIVEN,
    ) -> dict[str, Any]:
        n, width, height = len(views), whole("width", width), whole("height", height)
        if out is not None and type(out) is not dict and not isinstance(out, Mapping):
            raise TypeError(f"out: a {type(out).__name__}; a dict of arrays by name is wanted")
        if isinstance(layers, str):
            raise TypeError(f"layers '{layers}': a tuple is wanted: ('{layers}',)")
        pictures = dict(out) if out else {}
        words: dict[str, str] = {}  # by layer: the caller's word, the key of the result
        for word in pictures:
            layer = _checked_out(word, words)
            words[layer] = word
        for word in layers:
            words.setdefault(checked_layer("layers", word), word)
        if colour is not _NOT_GIVEN:
            deprecated("colour=", "rgb=")
            rgb = colour
            if rgb is not None:
                words.setdefault("rgb", "colour")
        if rgb is not None and "rgb" not in words:
            pictures, words["rgb"] = _Pictures(pictures), "rgb"
        drawn: dict[str, Any] = {}
        for layer, word in words.items():
            shape = _shape(layer, rgb, n, height, width)
            if word in pictures:
                _check_shape(word, pictures[word], shape)
            else:
                pictures[word] = self._core.memory(shape, _type(layer, rgb))
            drawn[layer] = pictures[word]
        try:
            self._core.render(
                views,
                width,
                height,
                vfov,
                drawn.get("rgb"),
                rgb or "rgb8",
                drawn.get("depth"),
                ray_depth,
                drawn.get("semantic"),
                drawn.get("instance"),
                _current_stream(drawn) if stream is None else whole("stream", stream, 2**64 - 1),
            )
        except TypeError as error:
            if not out:
                raise
            names = ", ".join(out)
            raise TypeError(
                f"out: {names}: contiguous, writable memory of the CPU, or for the back end cuda of "
                "its card, is wanted of each"
            ) from error
        return pictures

    def render_agents(self, simulator: Simulator, **options: Any) -> dict[str, Any]:
        """The current view of each agent of a simulator, with its camera; options are those of render().
        Raises ArgumentError for a simulator of other scans, or an agent without an episode."""
        if simulator.graphs is not self.graphs and simulator.graphs.scans != self.graphs.scans:
            raise ArgumentError("the simulator and the renderer are of different scans")
        simulator._check_begun()
        width = options.pop("width", simulator.width)
        height = options.pop("height", simulator.height)
        vfov = options.pop("vfov", simulator.vfov)
        return self._draw(simulator._views, width, height, vfov, **options)

    def render_36(self, scan: str, viewpoint: str, **options: Any) -> dict[str, Any]:
        """The 36 discretized views of a viewpoint, in the order of MatterSim's viewIndex."""
        views = np.arange(36)
        return self.render(
            [scan] * 36,
            [viewpoint] * 36,
            views % 12 * math.radians(30),
            (views // 12 - 1) * math.radians(30),
            **options,
        )


def _shape(layer: str, rgb: Optional[str], n: int, h: int, w: int) -> tuple[int, ...]:
    if layer != "rgb":
        return (n, h, w)
    if rgb in ("planar", "imagenet"):
        return (n, 3, h, w)
    return (n, h, w, 4 if rgb == "rgba8" else 3)


def _type(layer: str, rgb: Optional[str]) -> str:
    if layer != "rgb":
        return _TYPES[layer]
    if (rgb or "rgb8") not in _FORMATS:
        raise ArgumentError(f"rgb '{rgb}': one of {', '.join(_FORMATS)} is wanted")
    return _FORMATS[rgb or "rgb8"]


def _checked_out(word: str, words: Mapping[str, str]) -> str:
    """The layer of a key of `out`."""
    layer = layer_of(word)
    if layer not in LAYERS:
        raise ArgumentError(f"out['{word}']: one of {', '.join(LAYERS)} is wanted")
    if layer in words:
        raise ArgumentError(f"out['{word}']: the same as out['{words[layer]}']; one of them is wanted")
    return checked_layer("out", word)


def _check_shape(word: str, picture: Any, wanted: tuple[int, ...]) -> None:
    if type(picture).__module__.startswith("jax"):  # its arrays do not report that they are read-only
        raise ArgumentError(f"out['{word}']: JAX's arrays never change, so nothing can be drawn there")
    shape = getattr(picture, "shape", None)
    if shape is None:
        raise TypeError(f"out['{word}']: a {type(picture).__name__}; an array is wanted")
    if tuple(shape) != wanted:
        raise ArgumentError(f"out['{word}'] has shape {tuple(shape)}, not {wanted}")


def _current_stream(pictures: Mapping[str, Any]) -> Optional[int]:
    """The current stream of the library whose arrays are in GPU memory; None if there is none."""
    for picture in pictures.values():
        library = type(picture).__module__.partition(".")[0]
        # By name, because neither library has to be installed.
        if library == "torch" and picture.is_cuda:
            cuda = importlib.import_module("torch.cuda")
            return int(cuda.current_stream(picture.device).cuda_stream)
        if library == "cupy":
            return int(importlib.import_module("cupy").cuda.get_current_stream().ptr)
    return None


def _angles(name: str, values: ArrayLike, n: int) -> NDArray[np.float64]:
    if type(values) is np.ndarray and values.dtype == np.float64 and values.shape == (n,):
        return values
    try:
        return np.ascontiguousarray(np.broadcast_to(np.asarray(values, np.float64), (n,)))
    except (TypeError, ValueError) as error:
        raise ArgumentError(f"{name}: {n} numbers, or one, are wanted: {error}") from error
