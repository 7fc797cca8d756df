"""A line between two pseudoterminals, for a slave and a master of PROFIBUS; what each of them said is written down.

A pseudoterminal has no bit times: an answer is on the line as soon as it is written.
"""

import os
import pty
import select
import threading
import time
import tty


class Line:
    """Two ends of one line: what is written to one path is read at the other, until it is closed."""

    def __init__(self, log):
        """Writes what goes over the line to the file `log`: microseconds, sender, bytes."""
        self.ends = [pty.openpty() for _ in range(2)]
        for _, end in self.ends:
            tty.setraw(end)
        self.device, self.master = (os.ttyname(end) for _, end in self.ends)
        self.log = open(log, "w")
        self.quiet, self.stop = os.pipe()
        self.carrier = threading.Thread(target=self.carry, daemon=True)
        self.carrier.start()

    def carry(self):
        begin = time.monotonic()
        (device, _), (master, _) = self.ends
        while True:
            ready = select.select([device, master, self.quiet], [], [])[0]
            if self.quiet in ready:
                return
            for end in ready:
                octets = os.read(end, 4096)
                who, other = ("device", master) if end == device else ("master", device)
                self.log.write(f"{(time.monotonic() - begin) * 1e6:.0f} {who} {octets.hex(' ')}\n")
                os.write(other, octets)

    def close(self):
        os.write(self.stop, b"x")
        self.carrier.join()
        self.log.close()
        for descriptor in (self.quiet, self.stop, *self.ends[0], *self.ends[1]):
            os.close(descriptor)
