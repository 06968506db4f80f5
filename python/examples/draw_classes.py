"""Draws what the look-ups of a sidecar's objects say, from eight directions: a line a pixel, coloured by its class.

    python3 draw_classes.py tree.vcd tree.png        # needs Matplotlib

White is clear; dark is blocked by a proof, blue by statistics; orange is unclassified. `vc-info --picture` draws the
same without Python.
"""
import sys

import numpy
import vcd

STATISTICAL = 3  # beside the values of vcd.Visibility
NAMES = ("clear", "blocked", "unclassified", "statistical")
COLOURS = numpy.array([(245, 245, 245), (40, 44, 52), (224, 122, 31), (76, 120, 168)], numpy.uint8)
VIEWS = ((0, 0), (45, 0), (90, 0), (135, 0), (30, 30), (30, 60), (30, -40), (200, 25))  # azimuth, elevation


def lines_of_view(record, azimuth, elevation, pixels):
    """A segment through the whole object for each pixel, row by row from the top."""
    low, high = numpy.array(record.box_min), numpy.array(record.box_max)
    radius = numpy.linalg.norm(high - low) / 2
    a, e = numpy.radians((azimuth, elevation))
    towards = numpy.array((numpy.cos(e) * numpy.sin(a), numpy.sin(e), numpy.cos(e) * numpy.cos(a)))
    right = numpy.array((numpy.cos(a), 0, -numpy.sin(a)))
    up = numpy.cross(towards, right)
    step = (numpy.arange(pixels) + 0.5) / pixels * 2 - 1
    x, y = numpy.meshgrid(step, -step)
    start = (low + high) / 2 + radius * (x[..., None] * right + y[..., None] * up + 2 * towards)
    return vcd.segments(start.reshape(-1, 3), -4 * radius * towards)


def classes(all_of_it, proven, segments):
    """Of each segment a number: that of vcd.Visibility, or STATISTICAL."""
    answers = all_of_it.classify(segments)
    by_proof = proven.classify(segments)
    return numpy.where((answers == vcd.Visibility.BLOCKED) & (by_proof != answers), STATISTICAL, answers)


def draw(path, picture, pixels=384):
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    trusting, proven = vcd.open(path), vcd.open(path, proven_only=True)
    figure, axes = pyplot.subplots(2 * len(trusting), 4, figsize=(14, 7.4 * len(trusting)), squeeze=False)
    for number, (all_of_it, by_proof) in enumerate(zip(trusting, proven)):
        for view, (azimuth, elevation) in enumerate(VIEWS):
            found = classes(all_of_it, by_proof, lines_of_view(all_of_it.record, azimuth, elevation, pixels))
            shares = numpy.bincount(found, minlength=len(NAMES)) / len(found)
            axis = axes[2 * number + view // 4][view % 4]
            axis.imshow(COLOURS[found].reshape(pixels, pixels, 3))
            axis.axis("off")
            axis.set_title(f"{all_of_it.name or number}, azimuth {azimuth}°, elevation {elevation}°\n" +
                           ", ".join(f"{name} {share:.0%}" for name, share in zip(NAMES, shares)), fontsize=8)
    figure.tight_layout()
    figure.savefig(picture, dpi=80)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    draw(*sys.argv[1:])
