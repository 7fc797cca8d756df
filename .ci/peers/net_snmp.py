"""net-snmp, a manager of others, against the agent of the served XAC7718.

    python net_snmp.py CONTROL

Its programs snmpget, snmpgetnext, snmpbulkget, snmpwalk and snmpset read MIB-II and LLDP-MIB in both versions, walk through all
objects, and find out what the agent does not allow.
"""

import re
import subprocess

from common import *

SYSTEM, LLDP = "1.3.6.1.2.1.1", "1.0.8802.1.1.2.1"


def snmp(program, version, *words, community="public"):
    """The names and values that a program of net-snmp writes, as numbers, and its exit status; a message is a name without a value."""
    command = [program, "-v", version, "-c", community, "-On", "-Oe", "-Ox", "-t", "2", "-r", "0", "-m", "", DEVICE_IP, *words]
    done = subprocess.run(command, capture_output=True, text=True)
    lines = []
    for line in (done.stdout + done.stderr).strip().splitlines():
        # A long text in hexadecimal goes on in the next line.
        if lines and re.fullmatch("([0-9A-F]{2} )+", line.strip() + " "):
            lines[-1] = lines[-1].strip() + " " + line.strip()
        else:
            lines.append(line)
    parts = [line.partition(" = ") for line in lines]
    return [(name, value.strip()) for name, _, value in parts], done.returncode


def has(said, word):
    """Whether one of the messages has a word."""
    return any(word in name for name, _ in said)


def text_of(said):
    """The first value, a text in hexadecimal."""
    return bytes.fromhex(said[0][1].removeprefix("Hex-STRING: ")).decode()


def main():
    for version in ("1", "2c"):
        said, status = snmp("snmpget", version, f"{SYSTEM}.2.0", f"{SYSTEM}.7.0")
        check(f"get, version {version}", (status, [value for _, value in said]), (0, ["OID: .1.3.6.1.4.1.24686", "INTEGER: 74"]))
        said, status = snmp("snmpwalk", version, SYSTEM)
        check(f"walk through system, version {version}", (status, [name for name, _ in said]),
              (0, [f".{SYSTEM}.{number}.0" for number in range(1, 8)]))
        everything, status = snmp("snmpwalk", version, "1")
        names = [[int(number) for number in name.strip(".").split(".")] for name, value in everything if value]
        check(f"walk through all, version {version}: in order", (status, names), (0, sorted(names)))
        check(f"walk through all, version {version}: the port and the interface", dict(everything)[".1.3.6.1.2.1.2.1.0"], "INTEGER: 2")
    said, _ = snmp("snmpget", "1", f"{SYSTEM}.99.0")
    check("an unknown object, version 1", has(said, "noSuchName"), True)
    said, _ = snmp("snmpget", "2c", f"{SYSTEM}.99.0")
    check("an unknown object, version 2c", said[0][1], "No Such Object available on this agent at this OID")
    said, _ = snmp("snmpget", "2c", f"{SYSTEM}.1.1")
    check("an unknown instance, version 2c", said[0][1], "No Such Instance currently exists at this OID")
    said, status = snmp("snmpbulkget", "2c", "-Cn0", "-Cr4", SYSTEM)
    check("bulk", (status, [name for name, _ in said]), (0, [f".{SYSTEM}.{number}.0" for number in range(1, 5)]))
    said, status = snmp("snmpgetnext", "2c", f"{LLDP}.3.7.1.3")
    check("the port in LLDP-MIB", (status, text_of(said)), (0, f"port-001.{DEVICE_NAME}"))
    said, _ = snmp("snmpget", "2c", f"{LLDP}.5.3791.1.2.1.1.6.1")
    check("the station in LLDP-EXT-PNO-MIB", text_of(said), DEVICE_NAME)
    said, status = snmp("snmpset", "2c", f"{SYSTEM}.2.0", "o", "1.3.6.1.4.1.1", community="private")
    check("a set is refused", (status != 0, has(said, "notWritable")), (True, True))
    said, status = snmp("snmpget", "2c", f"{SYSTEM}.1.0", community="other")
    check("an unknown community has no answer", (status != 0, has(said, "Timeout")), (True, True))
    finish()


main()
