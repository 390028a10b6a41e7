"""Plays a motion over OpenIGTLink with pyigtl, as a client of the port given, or as a server with --server.

    python play.py PORT MOTION.json [--server]

MOTION.json: a list of [time in s, device, x, y, z in mm, quaternion x, y, z, w], in the order in which they are sent. With --server each
message is sent again and again until the peer has gone.
"""

import json
import sys
import time

import numpy as np
import pyigtl

# pyigtl drops what is older than a hundred messages in its queue.
BATCH = 50
# Time 0 means "unset" in the protocol.
START = 1.0


def matrix(x, y, z, w, place):
    found = np.eye(4)
    found[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    found[:3, 3] = place
    return found


def main():
    port, motion = int(sys.argv[1]), json.load(open(sys.argv[2]))
    is_server = "--server" in sys.argv
    peer = pyigtl.OpenIGTLinkServer(port=port) if is_server else pyigtl.OpenIGTLinkClient("127.0.0.1", port)
    while not peer.is_connected():
        time.sleep(0.01)
    while True:
        for index, (t, device, x, y, z, qx, qy, qz, qw) in enumerate(motion):
            last = index + 1 == len(motion)
            pose = matrix(qx, qy, qz, qw, (x, y, z))
            message = pyigtl.TransformMessage(pose, device_name=device, timestamp=START + t)
            peer.send_message(message, wait=last or index % BATCH == BATCH - 1)
        if not is_server or not peer.is_connected():
            break
        time.sleep(0.01)
    # What was handed to the socket is on its way.
    time.sleep(0.2)
    peer.stop()


main()
