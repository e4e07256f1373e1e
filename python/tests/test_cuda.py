"""The back end "cuda", into the memory of a card: skipped where there is none."""

from __future__ import annotations

import math
import os
from typing import Any

import enfilade
import numpy as np
import pytest


@pytest.fixture(scope="module")
def pictures(request: pytest.FixtureRequest) -> Any:
    """A data set with pictures: ENFILADE_TEST_HOMES, made elsewhere, or model homes made here."""
    folder = os.environ.get("ENFILADE_TEST_HOMES") or request.getfixturevalue("homes")
    graphs = enfilade.Dataset(folder).graphs
    return graphs, enfilade.open_panoramas(folder, graphs)


@pytest.fixture(scope="module")
def card(pictures: Any) -> Any:
    """A renderer with a card."""
    try:
        return enfilade.Renderer(*pictures, backend="cuda")
    except enfilade.Error as error:
        pytest.skip(str(error))


@pytest.fixture(scope="module")
def torch() -> Any:
    torch = pytest.importorskip("torch")
    if not torch.cuda.is_available():
        pytest.skip("PyTorch finds no card")
    return torch


def views(graphs: Any, count: int) -> tuple[Any, ...]:
    """Any places and directions, the same each time."""
    rng = np.random.default_rng(5)
    scan = graphs.scans[0]
    places = graphs[scan].viewpoints
    return (
        [scan] * count,
        [places[k] for k in rng.integers(len(places), size=count)],
        rng.uniform(0, 2 * math.pi, count),
        rng.uniform(-0.6, 0.6, count),
    )


def test_the_back_end_is_there_and_says_what_is_missing(pictures: Any) -> None:
    assert "cuda" in enfilade.backends()
    try:
        renderer = enfilade.Renderer(*pictures, backend="cuda")
    except enfilade.Error as error:
        assert "CUDA: " in str(error)
    else:
        assert renderer.description.startswith("cuda (")


@pytest.mark.parametrize("colour", ["rgb8", "bgr8", "rgba8", "planar", "imagenet"])
def test_draws_the_cpus_pictures_into_torchs_memory(
    pictures: Any, card: Any, torch: Any, colour: str
) -> None:
    cpu = enfilade.Renderer(*pictures)
    where = views(pictures[0], 40)
    options: dict[str, Any] = {"width": 64, "height": 48, "rgb": colour, "layers": ("depth",)}
    wanted = cpu.render(*where, **options)
    out = {name: torch.full(picture.shape, 7, dtype=getattr(torch, str(picture.dtype)), device="cuda")
           for name, picture in wanted.items()}  # fmt: skip
    drawn = card.render(*where, out=out, **options)
    for name, picture in wanted.items():
        assert drawn[name] is out[name]
        np.testing.assert_array_equal(drawn[name].cpu().numpy(), picture)
    on_host = card.render(*where, **options)
    for name, picture in wanted.items():
        np.testing.assert_array_equal(on_host[name], picture)


def test_halves_are_those_of_the_cpu(pictures: Any, card: Any, torch: Any) -> None:
    where = views(pictures[0], 12)
    options: dict[str, Any] = {"width": 224, "height": 224, "rgb": "imagenet"}
    wanted = np.empty((12, 3, 224, 224), np.float16)
    enfilade.Renderer(*pictures).render(*where, out={"rgb": wanted}, **options)
    out = torch.empty(wanted.shape, dtype=torch.float16, device="cuda")
    card.render(*where, out={"rgb": out}, **options)
    np.testing.assert_array_equal(out.cpu().numpy(), wanted)


def test_is_drawn_in_the_order_of_torchs_stream(pictures: Any, card: Any, torch: Any) -> None:
    where = views(pictures[0], 100)
    wanted = enfilade.Renderer(*pictures).render(*where)["rgb"]
    stream = torch.cuda.Stream()
    for current in (torch.cuda.current_stream(), stream):
        with torch.cuda.stream(current):
            out = torch.empty(wanted.shape, dtype=torch.uint8, device="cuda")
            busy = torch.randn(4096, 4096, device="cuda")
            for _ in range(20):
                busy = busy @ busy / 64
            out.fill_(7)  # behind milliseconds of work, and before the pictures
            card.render(*where, out={"rgb": out})
            total = out.sum(dtype=torch.int64)
        current.synchronize()
        assert int(total) == int(wanted.sum(dtype=np.int64))


def test_a_graph_draws_again(pictures: Any, card: Any, torch: Any) -> None:
    where = views(pictures[0], 30)
    options: dict[str, Any] = {"width": 64, "height": 48, "layers": ("depth",)}
    wanted = enfilade.Renderer(*pictures).render(*where, **options)
    out = {
        "rgb": torch.empty((30, 48, 64, 3), dtype=torch.uint8, device="cuda"),
        "depth": torch.empty((30, 48, 64), dtype=torch.float32, device="cuda"),
    }
    stream = torch.cuda.Stream()
    with torch.cuda.stream(stream):
        card.render(*where, out=out, **options)
        graph = torch.cuda.CUDAGraph()
        with torch.cuda.graph(graph, stream=stream):
            card.render(*where, out=out, **options)
    for picture in out.values():
        picture.zero_()
    torch.cuda.synchronize()
    graph.replay()
    torch.cuda.synchronize()
    for name, picture in wanted.items():
        np.testing.assert_array_equal(out[name].cpu().numpy(), picture)


def test_draws_into_cupys_memory(pictures: Any, card: Any) -> None:
    cupy = pytest.importorskip("cupy")
    where = views(pictures[0], 10)
    wanted = enfilade.Renderer(*pictures).render(*where)["rgb"]
    out = cupy.empty(wanted.shape, cupy.uint8)
    card.render(*where, out={"rgb": out})
    np.testing.assert_array_equal(cupy.asnumpy(out), wanted)


def test_memory_of_a_card_is_refused_by_other_back_ends(pictures: Any, torch: Any) -> None:
    out = torch.empty((1, 480, 640, 3), dtype=torch.uint8, device="cuda")
    with pytest.raises(enfilade.ArgumentError, match="the back end cpu"):
        enfilade.Renderer(*pictures).render(*views(pictures[0], 1), out={"rgb": out})


def test_a_stream_is_refused_by_other_back_ends(pictures: Any) -> None:
    with pytest.raises(enfilade.ArgumentError, match=r"outputs\.stream"):
        enfilade.Renderer(*pictures).render(*views(pictures[0], 1), stream=1)
