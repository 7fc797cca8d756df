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
    """The lines that a program of net-snmp writes, with names and values as numbers, and its exit status."""
    command = [program, "-v", version, "-c", community, "-On", "-Oe", "-Ox", "-t", "2", "-r", "0", "-m", "", DEVICE_IP, *words]
    done = subprocess.run(command, capture_output=True, text=True)
    lines = []
    for line in (done.stdout + done.stderr).strip().splitlines():
        # A long text in hexadecimal goes on in the next line.
        if lines and re.fullmatch("([0-9A-F]{2} )+", line.strip() + " "):
            lines[-1] = lines[-1].strip() + " " + line.strip()
        else:
            lines.append(line)
    return lines, done.returncode


def value(line):
    """The value in a line of net-snmp."""
    return line.partition(" = ")[2].strip()


def main():
    for version in ("1", "2c"):
        lines, status = snmp("snmpget", version, f"{SYSTEM}.2.0", f"{SYSTEM}.7.0")
        check(f"get, version {version}", (status, [value(line) for line in lines]), (0, ["OID: .1.3.6.1.4.1.24686", "INTEGER: 74"]))
        lines, status = snmp("snmpwalk", version, SYSTEM)
        names = [line.partition(" = ")[0] for line in lines]
        check(f"walk through system, version {version}", (status, names), (0, [f".{SYSTEM}.{number}.0" for number in range(1, 8)]))
        everything, status = snmp("snmpwalk", version, "1")
        names = [[int(number) for number in line.partition(" = ")[0].strip(".").split(".")] for line in everything if " = " in line]
        check(f"walk through all, version {version}: in order", (status, names), (0, sorted(names)))
        check(f"walk through all, version {version}: the port and the interface",
              value([line for line in everything if line.startswith(".1.3.6.1.2.1.2.1.0 ")][0]), "INTEGER: 2")
    lines, _ = snmp("snmpget", "1", f"{SYSTEM}.99.0")
    check("an unknown object, version 1", any("noSuchName" in line for line in lines), True)
    lines, _ = snmp("snmpget", "2c", f"{SYSTEM}.99.0")
    check("an unknown object, version 2c", value(lines[0]), "No Such Object available on this agent at this OID")
    lines, _ = snmp("snmpget", "2c", f"{SYSTEM}.1.1")
    check("an unknown instance, version 2c", value(lines[0]), "No Such Instance currently exists at this OID")
    lines, status = snmp("snmpbulkget", "2c", "-Cn0", "-Cr4", SYSTEM)
    check("bulk", (status, [line.partition(" = ")[0] for line in lines]), (0, [f".{SYSTEM}.{number}.0" for number in range(1, 5)]))
    lines, status = snmp("snmpgetnext", "2c", f"{LLDP}.3.7.1.3")
    check("the port in LLDP-MIB", (status, bytes.fromhex(value(lines[0]).removeprefix("Hex-STRING: ")).decode()),
          (0, f"port-001.{DEVICE_NAME}"))
    lines, status = snmp("snmpget", "2c", f"{LLDP}.5.3791.1.2.1.1.6.1")
    check("the station in LLDP-EXT-PNO-MIB", bytes.fromhex(value(lines[0]).removeprefix("Hex-STRING: ")).decode(), DEVICE_NAME)
    lines, status = snmp("snmpset", "2c", f"{SYSTEM}.2.0", "o", "1.3.6.1.4.1.1", community="private")
    check("a set is refused", (status != 0, any("notWritable" in line for line in lines)), (True, True))
    lines, status = snmp("snmpget", "2c", f"{SYSTEM}.1.0", community="other")
    check("an unknown community has no answer", (status != 0, any("Timeout" in line for line in lines)), (True, True))
    finish()


main()
