#!/usr/bin/env python3
"""Makes the seeds of the readers of weights and features with the programs that others make theirs with.

  make_weight_seeds.py      writes tests/fuzz/seeds/{pickle,feature_hdf5}

Needs PyTorch, numpy and h5py: on Debian, python3-torch and python3-h5py. The seeds are also what
tensor_file_test.cpp and feature_set_test.cpp compare with, and were made by PyTorch 1.13.
"""
import argparse
import collections
import pathlib
import pickle

import h5py
import numpy
import torch

SEEDS = pathlib.Path(__file__).parent / "seeds"


def tensors():
    base = torch.arange(6, dtype=torch.float32).reshape(2, 3) / 2
    named = collections.OrderedDict(
        f32=base,
        transposed=base.t(),
        column=base[:, 1],
        f16=torch.tensor([1.5, -2, 65504], dtype=torch.float16),
        bf16=torch.tensor([1, -3], dtype=torch.bfloat16),
        f64=torch.tensor([0.1], dtype=torch.float64),
        i32=torch.tensor([-1, 2], dtype=torch.int32),
        i64=torch.tensor(7),
        u8=torch.tensor([0, 255], dtype=torch.uint8),
        truth=torch.tensor([True, False, True]),
        empty=torch.zeros(0, 3),
        parameter=torch.nn.Parameter(torch.tensor([1.0, 2.0])),
    )
    named._metadata = collections.OrderedDict({"": {"version": 1}})
    return named


class OldPickler(pickle.Pickler):
    """Writes tensors and parameters as PyTorch 0.1 did."""

    def reducer_override(self, value):
        if isinstance(value, torch.nn.Parameter):
            state = (True, False, collections.OrderedDict())
            return torch.nn.parameter.Parameter, (value.data,), state
        if isinstance(value, torch.Tensor):
            arguments = (value.storage(), value.storage_offset(), tuple(value.size()), value.stride())
            return torch._utils._rebuild_tensor, arguments
        return NotImplemented


class OldPickle:
    Pickler = OldPickler
    dump = staticmethod(pickle.dump)
    load = staticmethod(pickle.load)


def save_tensors(folder):
    folder.mkdir(parents=True, exist_ok=True)
    old = {"_use_new_zipfile_serialization": False}
    torch.save(tensors(), folder / "zip.pth")
    torch.save(tensors(), folder / "legacy.pth", **old)
    torch.save(tensors(), folder / "legacy_4.pth", pickle_protocol=4, **old)
    torch.save(tensors(), folder / "very_old.pth", pickle_module=OldPickle, **old)
    few = {"f32": tensors()["f32"], "epoch": 1}
    checkpoint = {"epoch": 3, "best": 0.5, "state_dict": few, "optimizer": {"lr": [0.1, None]}}
    torch.save(checkpoint, folder / "checkpoint_4.pth", pickle_protocol=4)
    torch.save({"model": {"module": few}}, folder / "nested.pth", pickle_protocol=3)
    foreign = {"state_dict": few, "args": argparse.Namespace(lr=0.1)}
    torch.save(foreign, folder / "foreign.pth", **old)
    torch.save({"i16": torch.tensor([1], dtype=torch.int16)}, folder / "i16.pth", **old)


class Part(torch.nn.Module):
    def __init__(self):
        super().__init__()
        self.linear = torch.nn.Linear(2, 3).half()
        self.linear.weight.data = tensors()["f32"].t().half()
        self.linear.bias.data = torch.tensor([0.5, 1, 1.5]).half()

    def forward(self, x):
        return x @ self.linear.weight.t().float() + self.linear.bias.float()


class Whole(torch.nn.Module):
    """Modules in modules, a buffer, and a tensor that is neither: a constant of the traced code."""

    def __init__(self):
        super().__init__()
        self.parts = torch.nn.Sequential(Part(), torch.nn.ReLU())
        self.register_buffer("size", torch.tensor(224))
        self.mask = torch.tensor([[7.0, 8.0, 9.0]])

    def forward(self, x):
        return self.parts(x) * self.mask


def save_script(folder):
    """As OpenAI saved CLIP."""
    torch.jit.save(torch.jit.trace(Whole().eval(), torch.ones(1, 2)), folder / "script.pth")


def save_features(folder):
    """As HAMT's precompute scripts have it, but of 3 dimensions."""
    folder.mkdir(parents=True, exist_ok=True)
    kinds = [("f32.h5", "<f4", None, None), ("f16_gzip.h5", "<f2", "gzip", "latest"), ("f32_lzf.h5", "<f4", "lzf", None), ("f64.h5", ">f8", None, None)]
    for name, kind, packed, version in kinds:
        with h5py.File(folder / name, "w", libver=version) as file:
            for number, viewpoint in enumerate(["aa", "bb"]):
                views = numpy.arange(36 * 3).reshape(36, 3) / 4 + 100 * number
                dataset = file.create_dataset(f"scan_1_{viewpoint}", data=views.astype(kind), compression=packed)
                dataset.attrs["scanId"] = "scan_1"
                dataset.attrs["viewpointId"] = viewpoint
                dataset.attrs["image_w"] = 640
                dataset.attrs["image_h"] = 480
                dataset.attrs["vfov"] = 60


if __name__ == "__main__":
    save_tensors(SEEDS / "pickle")
    save_script(SEEDS / "pickle")
    save_features(SEEDS / "feature_hdf5")
