"""Opens the float buffers of a frame with OpenEXR and with OpenCV: an opinion from outside on what these readers accept.

    python check_exr.py FILE

Prints one line of JSON: {"name", "channels", "opencv"}. `name` is the part's name or null, `channels` the rows of every
channel by its name, `opencv` those of blue, green and red, each as the hexadecimal digits of little-endian 32-bit floats.
Needs OpenEXR 3 and OpenCV 4; the wheels of OpenCV 5 are built without OpenEXR.
"""

import json
import os
import sys

# Read when cv2 is loaded.
os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"

import cv2
import numpy
import OpenEXR


def digits(values):
    return numpy.ascontiguousarray(values, dtype="<f4").tobytes().hex()


def main(path):
    with OpenEXR.File(path, separate_channels=True) as file:
        if len(file.parts) != 1:
            sys.exit(f"{path}: {len(file.parts)} parts")
        name = file.header().get("name")
        channels = {channel: digits(values.pixels) for channel, values in file.channels().items()}
    picture = cv2.imread(path, cv2.IMREAD_UNCHANGED)
    if picture is None:
        sys.exit(f"{path}: OpenCV reads no picture")
    opencv = [digits(picture[..., channel]) for channel in range(picture.shape[2])]
    print(json.dumps({"name": name, "channels": channels, "opencv": opencv}))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: check_exr.py FILE")
    main(sys.argv[1])
