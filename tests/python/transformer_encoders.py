"""Vision Transformers of others with random weights: what ours are held against.

usage: transformer_encoders.py NAME FOLDER

NAME is vit-b-16 (timm), clip-vit-b-16 or clip-vit-b-32 (OpenAI's code), or transformers (CLIP
ViT-B/32 of Hugging Face). Writes FOLDER/weights.pth (as torch.save() does; for clip-vit-b-32 as
TorchScript, in which OpenAI published them) and
FOLDER/case.safetensors: `pictures` (2, 3, 240, 320) in whole numbers from 0 to 255, `resized`
(2, 3, 224, 224) as Pillow makes them, and `features` of them. Features are computed in float64 and
then rounded, so that they have no error of their own to speak of.
"""

import sys

import torch
from PIL import Image
from torchvision import transforms

from safetensors_file import write_safetensors


def spread(network):
    """Values as different as training leaves them: at first biases are 0 and many weights equal."""
    for name, values in network.named_parameters():
        if values.ndim == 1 and name.endswith("weight"):
            torch.nn.init.uniform_(values, 0.5, 1.5)
        elif values.ndim == 1 and name.endswith("bias"):
            torch.nn.init.uniform_(values, -0.5, 0.5)
    return network.eval()


def timm_network():
    import timm

    network = spread(timm.create_model("vit_base_patch16_224", pretrained=False))
    config = timm.data.resolve_data_config({}, model=network)

    def features(pictures):
        tokens = network.forward_features(pictures)
        tokens = tokens if tokens.ndim == 2 else tokens[:, 0]
        return torch.cat([tokens, network.head(tokens)], 1)

    return network, timm.data.create_transform(**config), features


def clip_network(patch):
    import clip

    network = clip.model.CLIP(512, 224, 12, 768, patch, 7, 90, 64, 1, 1).float()
    for norm in [m for m in network.modules() if isinstance(m, torch.nn.LayerNorm)]:
        norm.__class__ = torch.nn.LayerNorm  # theirs goes through float32, whatever it is given
    return spread(network), clip.clip._transform(224), network.encode_image


def transformers_network():
    import transformers

    config = transformers.CLIPVisionConfig(projection_dim=512, patch_size=32)
    network = spread(transformers.CLIPVisionModelWithProjection(config))
    # The transform of OpenAI's code, written out.
    mean, deviation = (0.48145466, 0.4578275, 0.40821073), (0.26862954, 0.26130258, 0.27577711)
    steps = [
        transforms.Resize(224, interpolation=transforms.InterpolationMode.BICUBIC),
        transforms.CenterCrop(224),
        transforms.ToTensor(),
        transforms.Normalize(mean, deviation),
    ]
    return (
        network,
        transforms.Compose(steps),
        lambda pictures: network(pixel_values=pictures).image_embeds,
    )


class Pictures(torch.nn.Module):
    """The half of CLIP that sees pictures, with the names that it has in the whole."""

    def __init__(self, network):
        super().__init__()
        self.visual = network.visual

    def forward(self, pictures):
        return self.visual(pictures)


def save(name, network, file):
    if name == "clip-vit-b-32":
        traced = torch.jit.trace(Pictures(network), torch.zeros(1, 3, 224, 224))
        torch.jit.save(traced, file)
    else:
        torch.save(network.state_dict(), file)


def is_resize(step):
    return isinstance(step, (transforms.Resize, transforms.CenterCrop))


def main(name, folder):
    torch.manual_seed(5)
    torch.set_grad_enabled(False)
    if name == "vit-b-16":
        network, transform, features = timm_network()
    elif name == "transformers":
        network, transform, features = transformers_network()
    else:
        network, transform, features = clip_network(int(name.rsplit("-", 1)[1]))
    save(name, network, f"{folder}/weights.pth")
    # Noise that is coarse in one picture and fine in the other: both smooth and sharp edges.
    coarse = torch.rand(3, 12, 16).repeat_interleave(20, 1).repeat_interleave(20, 2)
    pictures = torch.stack([coarse, torch.rand(3, 240, 320)]).mul(256).to(torch.uint8)
    images = [Image.fromarray(p.permute(1, 2, 0).numpy()) for p in pictures]
    resize = transforms.Compose([step for step in transform.transforms if is_resize(step)])
    resized = torch.stack([transforms.PILToTensor()(resize(image)) for image in images])
    network.double()
    found = features(torch.stack([transform(image) for image in images]).double())
    write_safetensors(
        f"{folder}/case.safetensors",
        {"pictures": pictures.float(), "resized": resized.float(), "features": found.float()},
    )


main(*sys.argv[1:])
