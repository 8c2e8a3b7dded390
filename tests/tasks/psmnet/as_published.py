"""PSMNet's forward pass written out once more, from the entries of a checkpoint, as a second opinion."""

from __future__ import annotations

import torch
from torch.nn import functional as F


def disparity_as_published(entries, left, right, max_disparity: int):
    """(N, H, W) disparities in evaluation [px], of images of multiples of 16 and no less than 256 pixels."""

    def norm(x, name):
        stats = (entries[f"{name}.{key}"] for key in ("running_mean", "running_var", "weight", "bias"))
        return F.batch_norm(x, *stats)

    def conv(x, name, stride=1, dilation=1):
        weight = entries[f"{name}.0.weight"]
        padding = dilation * (weight.shape[-1] // 2)
        apply = F.conv3d if weight.ndim == 5 else F.conv2d
        return norm(apply(x, weight, None, stride, padding, dilation), f"{name}.1")

    def double(x, name):
        out = F.conv_transpose3d(x, entries[f"{name}.0.weight"], None, 2, 1, 1)
        return norm(out, f"{name}.1")

    def layer(x, name, blocks, stride=1, dilation=1):
        for i in range(blocks):
            block, step = f"{name}.{i}", stride if i == 0 else 1
            out = conv(conv(x, f"{block}.conv1.0", step, dilation).relu(), f"{block}.conv2", 1, dilation)
            if f"{block}.downsample.0.weight" in entries:
                x = conv(x, f"{block}.downsample", step)
            x = out + x
        return x

    def features(x):
        pre = "feature_extraction"
        x = conv(x, f"{pre}.firstconv.0", stride=2).relu()
        x = conv(conv(x, f"{pre}.firstconv.2").relu(), f"{pre}.firstconv.4").relu()
        raw = layer(layer(x, f"{pre}.layer1", 3), f"{pre}.layer2", 16, stride=2)
        skip = layer(layer(raw, f"{pre}.layer3", 3), f"{pre}.layer4", 3, dilation=2)
        pooled = {}
        for branch, size in ((1, 64), (2, 32), (3, 16), (4, 8)):
            small = conv(F.avg_pool2d(skip, size, size), f"{pre}.branch{branch}.1").relu()
            pooled[branch] = F.interpolate(small, skip.shape[2:], mode="bilinear", align_corners=True)
        joined = torch.cat([raw, skip, pooled[4], pooled[3], pooled[2], pooled[1]], 1)
        out = conv(joined, f"{pre}.lastconv.0").relu()
        return F.conv2d(out, entries[f"{pre}.lastconv.2.weight"])

    def hourglass(x, name, presqu, postsqu):
        pre = conv(conv(x, f"{name}.conv1.0", stride=2).relu(), f"{name}.conv2")
        pre = (pre if postsqu is None else pre + postsqu).relu()
        out = conv(conv(pre, f"{name}.conv3.0", stride=2).relu(), f"{name}.conv4.0").relu()
        post = (double(out, f"{name}.conv5") + (pre if presqu is None else presqu)).relu()
        return double(post, f"{name}.conv6"), pre, post

    def classified(x, name):
        return F.conv3d(conv(x, f"{name}.0").relu(), entries[f"{name}.2.weight"], padding=1)

    a, b = features(left), features(right)
    levels = []
    for i in range(max_disparity // 4):
        shifted = F.pad(b, (i, 0))[..., : b.shape[-1]]
        seen = torch.arange(a.shape[-1]) >= i
        levels.append(torch.cat([a * seen, shifted], 1))
    cost = conv(conv(torch.stack(levels, 2), "dres0.0").relu(), "dres0.2").relu()
    cost = conv(conv(cost, "dres1.0").relu(), "dres1.2") + cost
    out1, pre1, post1 = hourglass(cost, "dres2", None, None)
    out2, _, post2 = hourglass(out1 + cost, "dres3", pre1, post1)
    out3, _, _ = hourglass(out2 + cost, "dres4", pre1, post2)
    total = sum(classified(out + cost, f"classif{i}") for i, out in enumerate((out1, out2, out3), 1))
    size = (max_disparity, *left.shape[2:])
    fine = F.interpolate(total, size, mode="trilinear", align_corners=True)[:, 0]
    return (F.softmax(fine, 1) * torch.arange(max_disparity)[None, :, None, None]).sum(1)
