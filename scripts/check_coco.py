"""Opens the COCO files of a set of images with pycocotools: an opinion from outside on masks, areas and boxes.

    python check_coco.py DIR

Every annotation is decoded; its mask must be the class of that number in the index label, and area and box must be those
that pycocotools finds. Every image must have one annotation of each category and lie where the file says.
Prints one line of JSON: {"files", "images", "annotations", "empty", "faults"}.
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


def main(folder):
    answer = {"files": 0, "images": 0, "annotations": 0, "empty": 0, "faults": []}
    for path in sorted((folder / "annotations").glob("*.json")):
        answer["files"] += 1
        check(folder, path, answer)
    print(json.dumps(answer))


def check(folder, path, answer):
    # The package prints how long it took.
    with contextlib.redirect_stdout(io.StringIO()):
        coco = COCO(str(path))
    kind = path.name.split("-")[0]
    for image in coco.loadImgs(coco.getImgIds()):
        answer["images"] += 1
        name = pathlib.Path(image["file_name"]).name
        labels = read_grey(folder / kind / name)
        found = coco.loadAnns(coco.getAnnIds(imgIds=image["id"]))
        faults = [f"{path.name}: {name}: {fault}" for fault in compare(coco, image, labels, found)]
        if not (folder / image["file_name"]).is_file():
            faults.append(f"{path.name}: {name}: no image there")
        answer["annotations"] += len(found)
        answer["empty"] += sum(annotation["area"] == 0 for annotation in found)
        answer["faults"] += faults


def compare(coco, image, labels, found):
    if labels.shape != (image["height"], image["width"]):
        yield f"labels of {labels.shape}"
        return
    if sorted(annotation["category_id"] for annotation in found) != sorted(coco.getCatIds()):
        yield "not one annotation of each category"
    for annotation in found:
        category = annotation["category_id"]
        if not numpy.array_equal(coco.annToMask(annotation) == 1, labels == category):
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
