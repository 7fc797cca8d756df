"""What the sessions with peers share: addresses, the served device, how a check is reported, the stand of the device."""

import socket
import sys
import time

INTERFACE = "c0"
CONTROLLER_MAC, CONTROLLER_IP = "02:00:00:00:00:01", "192.168.0.1"
DEVICE_MAC, DEVICE_IP, DEVICE_NAME = "02:00:00:00:01:00", "192.168.0.10", "encoder-1"
NETMASK, GATEWAY = "255.255.255.0", "0.0.0.0"

# The Lika XAC7718 as its manual and the description of the reference device have it.
VENDOR, DEVICE, STATION_TYPE = 0x0239, 0x0001, "LIKA ROTACOD"
ORDER_ID, SOFTWARE = "XAC7718/1PT", "V1.1.0"
# Module ident of the access point of slot 0; that of the encoder is 1.
DAP_IDENT = 2
ENCODER_API, TELEGRAM_81 = 0x3D00, 81
USER_PARAMETERS, PARAMETER_ACCESS, IM0 = 0xBF00, 0xB02E, 0xAFF0
# The record of the start-up: class 4 and the alarm channel on, no scaling, compatibility off, 2^18 steps, steps per second.
START_RECORD = bytes([0b110010]) + (1 << 18).to_bytes(8, "big") * 2 + bytes([1, 0]) + bytes(12)
# Device identification P964: vendor, type, software 1.10, of 24 October 2013, drive objects.
P964 = [0x0239, 1, 110, 2013, 2410, 1]

failures = 0


def check(what, observed, expected):
    """Reports one check in one line: passed if the observed value equals the expected one."""
    global failures
    if observed == expected:
        print(f"ok {what}", flush=True)
    else:
        failures += 1
        print(f"not ok {what}: expected {expected!r}, observed {observed!r}", flush=True)


def wait_for(what, read, expected, seconds=5.0):
    """Reads a value until it is the expected one, for at most `seconds`, and reports that as a check."""
    end = time.monotonic() + seconds
    while (observed := read()) != expected and time.monotonic() < end:
        time.sleep(0.01)
    check(what, observed, expected)


def finish():
    """Ends the session: the exit status says whether all checks went well."""
    sys.exit(1 if failures else 0)


def stand(command):
    """Sends a command to the served device's stand and gives its answer."""
    with socket.socket(socket.AF_UNIX) as line:
        line.settimeout(5)
        line.connect(sys.argv[1])
        line.sendall(command.encode() + b"\n")
        return line.makefile().readline().strip()


def read_request(reference, number, count=1, subindex=0):
    """A request of PROFIdrive for values of a parameter."""
    return bytes([reference, 1, 1, 1, 0x10, count]) + number.to_bytes(2, "big") + subindex.to_bytes(2, "big")


def change_request(reference, number, value):
    """A request of PROFIdrive to change a parameter of 32 bits."""
    return bytes([reference, 2, 1, 1, 0x10, 0]) + number.to_bytes(2, "big") + bytes([0, 0, 0x43, 1]) + value.to_bytes(4, "big")


def words(octets):
    """16-bit numbers in a row."""
    return [int.from_bytes(octets[at:at + 2], "big") for at in range(0, len(octets), 2)]
