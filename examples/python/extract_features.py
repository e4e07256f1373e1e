# %% [markdown]
"""
# Features by your own torch model

Of the 36 views of every viewpoint, in the field's TSV. As a program:
`python extract_features.py DATA OUT.tsv`

Here the model is a small untrained network; put torchvision's, CLIP's or yours in its place. Pictures
are drawn right into the tensor that the model reads.
"""

# %%
import sys

import enfilade
import torch
from enfilade import features

WIDTH, HEIGHT = 224, 224


# %%
def make_model() -> torch.nn.Module:
    torch.manual_seed(1)
    return torch.nn.Sequential(
        torch.nn.Conv2d(3, 16, 7, stride=4), torch.nn.ReLU(),
        torch.nn.Conv2d(16, 32, 5, stride=4), torch.nn.ReLU(),
        torch.nn.AdaptiveAvgPool2d(2), torch.nn.Flatten(),
    )  # fmt: skip


# %%
def main(data: str, out: str) -> None:
    graphs = enfilade.Graphs(f"{data}/connectivity")
    renderer = enfilade.Renderer(graphs, enfilade.open_panoramas(data, graphs))
    model = make_model().eval()
    pictures = torch.empty((36, 3, HEIGHT, WIDTH))
    found = {}
    with torch.no_grad():
        for scan in graphs.scans:
            graph = graphs[scan]
            for viewpoint in filter(graph.included, graph.viewpoints):
                renderer.render_36(
                    scan, viewpoint, rgb="imagenet", width=WIDTH, height=HEIGHT,
                    out={"rgb": pictures},
                )  # fmt: skip
                found[scan, viewpoint] = model(pictures).numpy()
    features.write_tsv(out, found, width=WIDTH, height=HEIGHT, vfov=60)
    print(f"{len(found)} viewpoints, {next(iter(found.values())).shape} each, in {out}")


# %% tags=["active-py"]
if __name__ == "__main__":
    main(*sys.argv[1:])

# %% tags=["active-ipynb"]
# from enfilade import synth
#
# synth.write_homes("homes", homes=3, face_size=64)  # synthetic
# main("homes", "features.tsv")

# %% [markdown]
"""
They are read again by viewpoint. A safetensors file (`features.write_safetensors`) would be mapped
instead of read, and `enfilade train` takes both.
"""

# %% tags=["active-ipynb"]
# read = features.open_features("features.tsv")
# {key: read[key].mean() for key in list(read)[:3]}
