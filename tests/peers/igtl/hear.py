"""Connects to a port with pyigtl, prints the first message of each device named, and ends.

    python hear.py PORT DEVICE...
"""

import json
import sys

import pyigtl

client = pyigtl.OpenIGTLinkClient("127.0.0.1", int(sys.argv[1]))
for device in sys.argv[2:]:
    message = client.wait_for_message(device, timeout=20)
    if message is None:
        sys.exit(f"nothing of {device} came")
    kind = type(message).__name__
    content = message.matrix.tolist() if hasattr(message, "matrix") else message.string
    print(json.dumps([device, kind, message.timestamp, content]), flush=True)
client.stop()
