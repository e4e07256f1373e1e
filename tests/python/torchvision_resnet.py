"""Torchvision's own ResNet with random weights: what ours is held against.

usage: torchvision_resnet.py NAME FOLDER

Writes FOLDER/weights.pth (as torch.save() does), FOLDER/weights.safetensors (float32), and
FOLDER/case.safetensors: `pictures` (2, 3, 64, 96), `features` of them, `features_bgr` of them with
their channels in reverse order. Features are computed in float64 and then rounded, so that they
have no error of their own to speak of.
"""
import copy
import sys

import torch
import torchvision
from torchvision.models.resnet import BasicBlock, Bottleneck

from safetensors_file import write_safetensors


def random_network(name):
    network = getattr(torchvision.models, name)(weights=None)
    for norm in [m for m in network.modules() if isinstance(m, torch.nn.BatchNorm2d)]:
        norm.momentum = 1.0  # the statistics become those of the next pictures
        torch.nn.init.uniform_(norm.weight, 0.5, 1.5)
        torch.nn.init.uniform_(norm.bias, -0.5, 0.5)
    # Branches weaker than the trunk that they are added to, as training leaves them. With branches
    # as strong, 50 blocks make a rounding error 500 times as large as it was, and torchvision's own
    # ResNet-152 in float32 is 2e-4 to 4e-4 off itself in float64; with these, 4e-6.
    for block in network.modules():
        last = {BasicBlock: "bn2", Bottleneck: "bn3"}.get(type(block))
        if last:
            torch.nn.init.uniform_(getattr(block, last).weight, 0.1, 0.3)
    network.train()(torch.randn(2, 3, 64, 96))
    return network.eval()


def features(network, pictures):
    headless = torch.nn.Sequential(*list(copy.deepcopy(network).double().children())[:-1])
    return headless(pictures.double()).flatten(1)


def main(name, folder):
    torch.manual_seed(5)
    with torch.no_grad():
        network = random_network(name)
        torch.save(network.state_dict(), f"{folder}/weights.pth")
        write_safetensors(
            f"{folder}/weights.safetensors",
            {k: v for k, v in network.state_dict().items() if v.dtype == torch.float32},
        )
        pictures = torch.randn(2, 3, 64, 96)
        write_safetensors(
            f"{folder}/case.safetensors",
            {
                "pictures": pictures,
                "features": features(network, pictures),
                "features_bgr": features(network, pictures.flip(1)),
            },
        )


main(*sys.argv[1:])
