#!/usr/bin/env python3
"""Dissects requests and responses of the base mode parameter access with tshark.

    pip install scapy==2.8.0        # tshark 4.0.17
    python3 parameter.py

writes `tshark-parameter.txt`: `name hex field=values`, the data of record 0xB02E as built below by hand and their
dissection by tshark 4.0.17, numbers in hex. The records are in an IODWriteReq (requests) and an IODReadRes (responses)
over DCE/RPC, built with scapy. None has an odd number of bytes: tshark does not support the padding byte.
"""
import pathlib
import struct
import subprocess
import tempfile
import uuid

from scapy.contrib.pnio_rpc import IODReadRes, IODWriteReq, PNIOServiceReqPDU, PNIOServiceResPDU
from scapy.layers.dcerpc import DceRpc4
from scapy.layers.inet import IP, UDP
from scapy.layers.l2 import Ether
from scapy.packet import Raw
from scapy.utils import wrpcap

HERE = pathlib.Path(__file__).parent

requests = {
    "read_one": "01 01 00 01  10 00 FDE8 0000",
    "read_array": "7F 01 01 01  10 06 03C4 0000",
    "read_three": "02 01 01 03  10 00 039A 0000  10 01 03C4 0005  10 00 FDE9 0002",
    "read_description": "03 01 01 01  20 00 03C4 0001",
    "read_text": "04 01 01 01  30 01 03C4 0000",
    "change_double_word": "05 02 01 01  10 00 FDE8 0000  43 01 00012345",
    "change_word": "06 02 01 01  10 00 03CB 0000  42 01 0001",
    "change_two": "07 02 01 02  10 00 FDE8 0000  10 00 039A 0000  43 01 00000064  42 01 0052",
    "change_bytes": "08 02 01 02  10 02 03E8 0000  10 00 03E9 0000  41 02 7F FF  42 01 1234",
}
responses = {
    "read_double_word": "01 01 00 01  43 01 00000064",
    "read_words": "7F 01 01 01  42 06 0239 0001 0100 07E8 1DFE 0001",
    "read_mixed": "02 81 01 03  42 01 0051  44 01 0003  43 01 00000000",
    "read_refused_subindex": "09 81 01 01  44 02 0003 0007",
    "change_refused": "0A 82 01 02  40 00  44 01 0001",
    "changed": "05 02 01 01",
    "unknown_parameter": "0B 81 01 01  44 01 0000",
}

PREFIX = "pn_io.profidrive.parameter."
FIELDS = ["request_reference", "request_id", "response_id", "do", "no_of_parameters", "attribute", "no_of_elems", "number",
          "index", "format", "no_of_values", "value_b", "value_w", "value_dw", "error_num", "error_subindex"]
AR = uuid.UUID(int=0x11)
INTERFACE = uuid.UUID("dea00001-6c97-11d1-8271-00a02442df7d")


def frame(name, octets):
    is_request = name in requests
    rpc = dict(endian="big", flags1=0x20, if_id=INTERFACE, object=uuid.UUID(int=1), act_id=uuid.UUID(int=2))
    block = dict(ARUUID=AR, API=0x3D00, slotNumber=1, subslotNumber=1, index=0xB02E, recordDataLength=len(octets))
    if is_request:
        header = bytes(IODWriteReq(**block))[:64] + octets
        body = struct.pack("!IIIII", 4096, len(header), 4096, 0, len(header)) + header
        payload = DceRpc4(ptype=0, opnum=3, **rpc)
    else:
        header = bytes(IODReadRes(**block))[:64] + octets
        body = struct.pack("!IIIII", 0, len(header), 4096, 0, len(header)) + header
        payload = DceRpc4(ptype=2, opnum=2, **rpc)
    port = dict(sport=49152, dport=34964) if is_request else dict(sport=34964, dport=49152)
    return Ether(src="02:00:00:00:00:01", dst="02:00:00:00:01:00") / IP(src="192.168.0.1", dst="192.168.0.10") / \
        UDP(**port) / payload / Raw(body)


def main():
    named = [(name, bytes.fromhex(text)) for name, text in (*requests.items(), *responses.items())]
    with tempfile.TemporaryDirectory() as scratch:
        pcap = f"{scratch}/parameter.pcap"
        wrpcap(pcap, [frame(name, octets) for name, octets in named])
        options = [option for field in FIELDS for option in ("-e", PREFIX + field)]
        lines = subprocess.run(["tshark", "--disable-protocol", "wg", "-r", pcap, "-T", "fields", *options], check=True,
                               capture_output=True, text=True).stdout.splitlines()
    with open(HERE / "tshark-parameter.txt", "w") as out:
        out.write("# Made by parameter.py: data of record 0xB02E and their dissection by tshark 4.0.17, `name hex field=values`.\n")
        for (name, octets), line in zip(named, lines, strict=True):
            read = [f"{field}={','.join(hex(int(value, 0)) for value in values.split(','))}"
                    for field, values in zip(FIELDS, line.split("\t"), strict=True) if values]
            out.write(" ".join([name, octets.hex(), *read]) + "\n")


main()
