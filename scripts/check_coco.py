"""Opens the COCO files of a set of images with pycocotools: an opinion from outside on masks, areas and boxes.

    python check_coco.py DIR

Every annotation is decoded. The mask of a class must be that class in the index label, that of the workpiece its labelled
pixels, and the masks of welds and of the tool their instances in its view; area and box must be those that pycocotools
finds. What an image does not show must have no annotation, and every image must lie where the file beside it says.
Prints one line of JSON: {"files", "images", "annotations", "faults"}.
"""

import contextlib
import io
import json
import pathlib
import sys
import zlib

import numpy
from pycocotools import mask
from pycocotools.coco import COCO

KINDS = ("appearance", "dose")
# Number of the tool in instance labels.
TOOL_INSTANCE = 255


def main(folder):
    answer = {"files": 0, "images": 0, "annotations": 0, "faults": []}
    for path in sorted(path for kind in KINDS for path in folder.glob(f"*/{kind}.json")):
        answer["files"] += 1
        check(folder, path, answer)
    print(json.dumps(answer))


def check(folder, path, answer):
    # The package prints how long it took.
    with contextlib.redirect_stdout(io.StringIO()):
        coco = COCO(str(path))
    lines = [json.loads(line) for line in (path.parent / "metadata.jsonl").read_text().splitlines()]
    places = {line["file_name"]: line for line in lines}
    for image in coco.loadImgs(coco.getImgIds()):
        answer["images"] += 1
        name = image["file_name"]
        labels = read_grey(folder / places[name][path.stem])
        instances = read_grey(folder / places[name]["instances"])
        found = coco.loadAnns(coco.getAnnIds(imgIds=image["id"]))
        faults = [f"{path}: {name}: {fault}" for fault in compare(coco, image, (labels, instances), found)]
        if not (path.parent / name).is_file():
            faults.append(f"{path}: {name}: no image there")
        answer["annotations"] += len(found)
        answer["faults"] += faults


def expected(labels, instances):
    """The masks that an image must have, by category; categories are numbered as in the file."""
    last = int(instances[instances < TOOL_INSTANCE].max(initial=0))
    welds = [instances == weld for weld in range(2, last + 1)]
    masks = [(1, labels == 1), (2, labels == 2), (3, labels != 0)] + [(4, weld) for weld in welds]
    masks.append((5, instances == TOOL_INSTANCE))
    return [(category, shown) for category, shown in masks if shown.any()]


def compare(coco, image, planes, found):
    labels, instances = planes
    if labels.shape != (image["height"], image["width"]) or instances.shape != labels.shape:
        yield f"labels of {labels.shape}, instances of {instances.shape}"
        return
    wanted = expected(labels, instances)
    if [annotation["category_id"] for annotation in found] != [category for category, _ in wanted]:
        yield f"categories {[annotation['category_id'] for annotation in found]}"
        return
    for annotation, (category, shown) in zip(found, wanted):
        if not numpy.array_equal(coco.annToMask(annotation) == 1, shown):
            yield f"the mask of category {category} is not its label"
        rle = coco.annToRLE(annotation)
        if int(mask.area(rle)) != annotation["area"]:
            yield f"area {annotation['area']} of category {category} is not {mask.area(rle)}"
        if mask.toBbox(rle).tolist() != [float(side) for side in annotation["bbox"]]:
            yield f"box {annotation['bbox']} of category {category} is not {mask.toBbox(rle).tolist()}"


def read_grey(path):
    """A PNG of one channel of eight bits without interlacing, by the standard library alone."""
    data = path.read_bytes()
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        sys.exit(f"{path}: not a PNG file")
    at, packed, header = 8, b"", None
    while at < len(data):
        length, kind = int.from_bytes(data[at:at + 4], "big"), data[at + 4:at + 8]
        body = data[at + 8:at + 8 + length]
        header = body if kind == b"IHDR" else header
        packed += body if kind == b"IDAT" else b""
        at += 12 + length
    width, height = int.from_bytes(header[:4], "big"), int.from_bytes(header[4:8], "big")
    if header[8:13] != b"\x08\x00\x00\x00\x00":
        sys.exit(f"{path}: not one channel of eight bits")
    rows = numpy.frombuffer(zlib.decompress(packed), numpy.uint8).reshape(height, width + 1)
    return unfiltered(rows[:, 0], rows[:, 1:].astype(int))


def unfiltered(filters, rows):
    """Rows after the filters of PNG (ISO/IEC 15948, 9) are undone."""
    out = numpy.zeros_like(rows)
    above = numpy.zeros(rows.shape[1], int)
    for y, (kind, row) in enumerate(zip(filters, rows)):
        if kind == 0:
            line = row
        elif kind == 1:
            line = numpy.cumsum(row) % 256
        elif kind == 2:
            line = (row + above) % 256
        else:
            line = slowly(kind, row, above)
        out[y] = above = line
    return out


def slowly(kind, row, above):
    """Filters that need the result to the left: mean, and Paeth's."""
    line, left, corner = numpy.zeros_like(row), 0, 0
    for x, (value, up) in enumerate(zip(row.tolist(), above.tolist())):
        if kind == 3:
            guess = (left + up) // 2
        else:
            near = left + up - corner
            guess = min((left, up, corner), key=lambda at: abs(near - at))
        left, corner = (value + guess) % 256, up
        line[x] = left
    return line


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: check_coco.py DIR")
    main(pathlib.Path(sys.argv[1]))
