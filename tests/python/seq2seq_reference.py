"""The sequence-to-sequence network once more, in PyTorch's own modules and its autograd.

Usage: seq2seq_reference.py FILE

FILE (safetensors; written by numerics_test.cpp) holds weights, a batch, masks of dropout, and what
Enfilade made of them: loss, gradients, and weights after updates by Adam. All of it is computed
again here in double precision, and the largest differences are printed, relative to the largest
number of each array. Exits with 1 if one is above the tolerance.

Written from the paper's equations (Anderson et al. 2018, section 4.3) and PyTorch's documentation.
"""

import json
import struct
import sys

import numpy
import torch
from torch import nn
from torch.nn.utils.rnn import pack_padded_sequence, pad_packed_sequence

TYPES = {"F32": numpy.float32, "F64": numpy.float64, "I32": numpy.int32, "U8": numpy.uint8}
# Single precision rounds at 6e-8; sums over some hundred terms and a chain of up to 30 steps.
TOLERANCE = 1e-5


def read(path):
    with open(path, "rb") as file:
        data = file.read()
    (length,) = struct.unpack("<Q", data[:8])
    header = json.loads(data[8 : 8 + length])
    arrays = {}
    for name, entry in header.items():
        if name == "__metadata__":
            continue
        begin, end = (8 + length + offset for offset in entry["data_offsets"])
        array = numpy.frombuffer(data[begin:end], TYPES[entry["dtype"]])
        arrays[name] = torch.from_numpy(array.reshape(entry["shape"]).copy())
    return arrays


class Encoder(nn.Module):
    def __init__(self, words, embedding, hidden):
        super().__init__()
        self.embedding = nn.Embedding(words, embedding, padding_idx=0)
        self.lstm = nn.LSTM(embedding, hidden, batch_first=True)
        self.encoder2decoder = nn.Linear(hidden, hidden)

    def forward(self, tokens, lengths, word_mask, context_mask):
        words = self.embedding(tokens[:, : lengths.max()]) * word_mask
        packed = pack_padded_sequence(words, lengths, batch_first=True, enforce_sorted=False)
        outputs, (last, cells) = self.lstm(packed)
        context, _ = pad_packed_sequence(outputs, batch_first=True)
        return context * context_mask, torch.tanh(self.encoder2decoder(last[0])), cells[0]


class Attention(nn.Module):
    def __init__(self, hidden):
        super().__init__()
        self.linear_in = nn.Linear(hidden, hidden, bias=False)
        self.linear_out = nn.Linear(2 * hidden, hidden, bias=False)

    def forward(self, hidden, context, padding):
        scores = torch.einsum("nlh,nh->nl", context, self.linear_in(hidden))
        weights = torch.softmax(scores.masked_fill(padding, -torch.inf), 1)
        mixed = torch.einsum("nl,nlh->nh", weights, context)
        return torch.tanh(self.linear_out(torch.cat((mixed, hidden), 1)))


class Decoder(nn.Module):
    def __init__(self, action, features, hidden):
        super().__init__()
        self.embedding = nn.Embedding(8, action)
        self.lstm = nn.LSTMCell(action + features, hidden)
        self.attention_layer = Attention(hidden)
        self.decoder2action = nn.Linear(hidden, 6)


class Network(nn.Module):
    def __init__(self, arrays):
        super().__init__()
        words, embedding = arrays["encoder.embedding.weight"].shape
        hidden = arrays["encoder.encoder2decoder.bias"].shape[0]
        action = arrays["decoder.embedding.weight"].shape[1]
        features = arrays["decoder.lstm.weight_ih"].shape[1] - action
        self.encoder = Encoder(words, embedding, hidden)
        self.decoder = Decoder(action, features, hidden)
        self.load_state_dict(
            {name: arrays[name] for name in arrays if name.startswith(("encoder.", "decoder."))}
        )
        self.double()

    def loss(self, a):
        tokens = a["tokens"].long()
        lengths = torch.tensor([int((row != 0).sum()) for row in tokens])
        context, hidden, cells = self.encoder(tokens, lengths, a["mask.words"], a["mask.context"])
        padding = tokens[:, : lengths.max()] == 0
        total = 0
        for t in range(a["labels"].shape[0]):
            seen = torch.cat((self.decoder.embedding(a["inputs"][t].long()), a["features"][t]), 1)
            seen = seen * torch.cat((a["mask.actions"][t], a["mask.features"][t]), 1)
            hidden, cells = self.decoder.lstm(seen, (hidden, cells))
            dropped = hidden * a["mask.attention"][t]
            logits = self.decoder.decoder2action(
                self.decoder.attention_layer(dropped, context, padding)
            )
            closed = torch.zeros_like(logits, dtype=torch.bool)
            closed[:, 4] = a["forward_open"][t] == 0
            total = total + nn.functional.cross_entropy(
                logits.masked_fill(closed, -torch.inf), a["labels"][t].long(), ignore_index=-1
            )
        return total


def difference(found, expected):
    largest = expected.abs().max().item()
    return (found.double() - expected).abs().max().item() / (largest if largest > 0 else 1)


def adam_differences(arrays):
    """Two optimisers, fed with Enfilade's own gradients: an update's size depends little on them."""
    network = Network(arrays)
    settings = {"lr": 1e-4, "weight_decay": 5e-4}
    optimisers = [
        torch.optim.Adam(part.parameters(), **settings)
        for part in (network.encoder, network.decoder)
    ]
    for step in range(arrays["updates"].item()):
        for name, weight in network.named_parameters():
            weight.grad = arrays[f"adam.{step}.gradient.{name}"].double()
        for optimiser in optimisers:
            optimiser.step()
    for name, weight in network.named_parameters():
        yield "adam." + name, difference(arrays["after." + name], weight.detach())


def main():
    arrays = read(sys.argv[1])
    arrays = {n: x.double() if x.dtype == torch.float32 else x for n, x in arrays.items()}
    network = Network(arrays)
    loss = network.loss(arrays)
    loss.backward()
    found = {"loss": difference(arrays["loss"], loss.detach())}
    for name, weight in network.named_parameters():
        found["gradient." + name] = difference(arrays["gradient." + name], weight.grad)
    found.update(adam_differences(arrays))
    for name, value in found.items():
        print(f"{value:.2e} {name}")
    return 1 if max(found.values()) > TOLERANCE else 0


sys.exit(main())
