"""Writes frames as pyigtl packs them, a line each: name, then the bytes in hexadecimal.

    pip install pyigtl==0.3.4 && python frames.py > pyigtl-0.3.txt

The values are those of `frames.rs`, which decodes them. POSITION is left out: pyigtl's is a record of its own.
"""

import numpy as np
import pyigtl

TURNED = np.array([[0, -1, 0, 1.5], [1, 0, 0, -2.25], [0, 0, 1, 300], [0, 0, 0, 1]], dtype=float)
TIME = 1767323045.75

for name, message in [
    ("TRANSFORM", pyigtl.TransformMessage(TURNED, device_name="Forceps", timestamp=TIME)),
    ("STRING", pyigtl.StringMessage("Gruen", device_name="Forceps", timestamp=TIME)),
]:
    for version in (1, 2):
        message.header_version = version
        print(f"{name}-{version}", message.pack().hex())

message = pyigtl.StringMessage("Gruen", device_name="Forceps", timestamp=TIME)
message.header_version = 2
message.metadata = {"unit": "mm", "station": "2"}
print("STRING-metadata", message.pack().hex())
