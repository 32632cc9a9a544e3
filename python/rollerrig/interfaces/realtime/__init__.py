"""The rig in real time: a server that holds the plant, and a client for controllers in Python.

    case -> [server] <- UDP: commands in, sensors out -> [client] your controller

`rollerrig serve` is the server's command; the frames are described in docs/how_to/real_time.md and, for C, in `c_header()`.
"""

from rollerrig.interfaces.realtime.client import Client as Client
from rollerrig.interfaces.realtime.client import Sensors as Sensors
from rollerrig.interfaces.realtime.frames import c_header as c_header
from rollerrig.interfaces.realtime.links import ClientError as ClientError
