#!/usr/bin/env python3
"""Builds alarm frames and records with scapy, and dissects the frames with tshark.

    pip install scapy==2.8.0        # tshark 4.0.17
    python3 alarm.py

writes `scapy-alarm.txt` (`name hex`: the bytes after the frame ID, or a record) and `tshark-alarm.txt` (`name field=values`:
the dissection of these frames by tshark 4.0.17, numbers in hex).

Where scapy has no class (AlarmAck, ERR-RTA, DiagnosisData, ModuleDiff, identification) the fields are packed with `struct`,
and only tshark is independent. Scapy has the version of an RTA PDU in the low and the type in the high four bits, tshark and
the standard the other way round; the two fields are swapped here.
"""
import pathlib
import struct
import subprocess
import tempfile

from scapy.contrib.pnio_rpc import (Alarm_High, Alarm_Low, AlarmNotification_High, AlarmNotification_Low, DiagnosisItem,
                                    IM0Block, IM1Block, IM2Block, IM3Block, IM4Block, MaintenanceItem)
from scapy.layers.l2 import Ether
from scapy.utils import wrpcap

HERE = pathlib.Path(__file__).parent
HIGH, LOW = 0xFC01, 0xFE01


def rta(cls, kind, sdu, flags=0x11, send=0, ack=0xFFFE, length=None):
    header = dict(AlarmDstEndpoint=0x0102, AlarmSrcEndpoint=0x0304, PDUTypeType=1, PDUTypeVersion=kind, AddFlags=flags,
                  SendSeqNum=send, AckSeqNum=ack, VarPartLen=len(bytes(sdu)) if length is None else length)
    return bytes(cls(RTA_SDU=sdu, **header))


def raw_rta(kind, part, flags=0x01, send=0x0005, ack=0x0004):
    return struct.pack("!HHBBHHH", 0x0102, 0x0304, 0x10 | kind, flags, send, ack, len(part)) + part


def notification(cls, alarm_type, specifier, items, slot=1, subslot=2):
    return cls(AlarmType=alarm_type, API=0x3D00, SlotNumber=slot, SubslotNumber=subslot, ModuleIdentNumber=0x11223344,
               SubmoduleIdentNUmber=0x00000051, AlarmSpecifier=specifier, AlarmPayload=items)


def channel(usi, number, properties, error, **more):
    return DiagnosisItem(UserStructureIdentifier=usi, ChannelNumber=number, ChannelProperties=properties,
                         ChannelErrorType=error, **more)


maintenance = MaintenanceItem(UserStructureIdentifier=0x8100, block_type=0x0F00, block_length=8, padding=b"\0\0",
                              MaintenanceStatus=1)
ack_block = struct.pack("!HHBBHIHHHBBBB", 0x8002, 18, 1, 0, 0x0001, 0x3D00, 1, 2, 0xA805, 0, 0, 0, 0)
refused_block = struct.pack("!HHBBHIHHHBBBB", 0x8001, 18, 1, 0, 0x0001, 0x3D00, 1, 2, 0xA805, 0xDA, 0x81, 0x3C, 0x00)

frames = {
    "channel": (LOW, rta(Alarm_Low, 1, notification(
        AlarmNotification_Low, 0x0001, 0xA805, [channel(0x8000, 0x8000, 0x0800, 0x9000)]), send=0xFFFF)),
    "disappears": (LOW, rta(Alarm_Low, 1, notification(
        AlarmNotification_Low, 0x000C, 0x0006, [channel(0x8000, 0x8000, 0x1000, 0x9000)]), send=0x0000, ack=0x0000)),
    "extended": (HIGH, rta(Alarm_High, 1, notification(
        AlarmNotification_High, 0x0001, 0xB807,
        [channel(0x8002, 3, 0x2B05, 0x8001, ExtChannelErrorType=0x8005, ExtChannelAddValue=0xDEADBEEF)]))),
    "qualified": (LOW, rta(Alarm_Low, 1, notification(
        AlarmNotification_Low, 0x0001, 0x8808,
        [channel(0x8003, 4, 0x0E00, 0x8002, ExtChannelErrorType=0x8001, ExtChannelAddValue=7,
                 QualifiedChannelQualifier=0x80)]))),
    "maintenance": (LOW, rta(Alarm_Low, 1, notification(
        AlarmNotification_Low, 0x0001, 0x0FFF, [maintenance, channel(0x8000, 0x8000, 0x0A00, 0x9010)]))),
    "two_items": (LOW, rta(Alarm_Low, 1, notification(
        AlarmNotification_Low, 0x0001, 0xA809,
        [channel(0x8000, 0x8000, 0x0800, 0x9000), channel(0x8000, 0x8000, 0x1A00, 0x9005)]))),
    "plug_wrong": (LOW, rta(Alarm_Low, 1, notification(AlarmNotification_Low, 0x000A, 0x000A, []))),
    "ack": (LOW, raw_rta(1, ack_block, flags=0x11)),
    "ack_refused": (HIGH, raw_rta(1, refused_block, flags=0x11)),
    "transport_ack": (LOW, raw_rta(3, b"")),
    "transport_nack": (HIGH, raw_rta(2, b"")),
    "error": (LOW, raw_rta(4, bytes([0xCF, 0x81, 0xFD, 0x05]))),
}

im0 = IM0Block(VendorIDHigh=2, VendorIDLow=0x39, OrderID=b"XAC77 27/2048       ", IMSerialNumber=b"SN0000000001    ",
               IMHardwareRevision=3, IMSWRevisionPrefix=b"V", IMSWRevisionFunctionalEnhancement=1, IMSWRevisionBugFix=2,
               IMSWRevisionInternalChange=7, IMRevisionCounter=9, IMProfileID=0x3D00, IMProfileSpecificType=1,
               IMSupported=0x001E)
records = {
    "im0": im0,
    "im1": IM1Block(IMTagFunction=b"height of the crane".ljust(32), IMTagLocation=b"hall 4".ljust(22)),
    "im2": IM2Block(IMDate=b"2024-02-29 12:34"),
    "im3": IM3Block(IMDescriptor=b"a descriptor".ljust(54)),
    "im4": IM4Block(IMSignature=bytes(range(54))),
}

FIELDS = {
    "frame_id": "pn_rt.frame_id", "dst": "pn_io.alarm_dst_endpoint", "src": "pn_io.alarm_src_endpoint",
    "kind": "pn_io.pdu_type.type", "version": "pn_io.pdu_type.version", "window": "pn_io.window_size",
    "tack": "pn_io.tack", "send": "pn_io.send_seq_num", "ack": "pn_io.ack_seq_num", "length": "pn_io.var_part_len",
    "block": "pn_io.block_type", "alarm_type": "pn_io.alarm_type", "api": "pn_io.api", "slot": "pn_io.slot_nr",
    "subslot": "pn_io.subslot_nr", "module": "pn_io.module_ident_number", "submodule": "pn_io.submodule_ident_number",
    "sequence": "pn_io.alarm_specifier.sequence", "channel_diagnosis": "pn_io.alarm_specifier.channel",
    "manufacturer": "pn_io.alarm_specifier.manufacturer", "submodule_state": "pn_io.alarm_specifier.submodule",
    "ar_state": "pn_io.alarm_specifier.ardiagnosis", "structure": "pn_io.user_structure_identifier",
    "channel": "pn_io.channel_number", "type": "pn_io.channel_properties.type",
    "accumulative": "pn_io.channel_properties.accumulative", "severity": "pn_io.channel_properties.maintenance",
    "change": "pn_io.channel_properties.specifier", "direction": "pn_io.channel_properties.direction",
    "error_type": "pn_io.channel_error_type", "add_value": "pn_io.ext_channel_add_value",
    "qualifier": "pn_io.qualified_channel_qualifier", "maintenance": "pn_io.maintenance_status",
    "error_code": "pn_io.error_code", "error_decode": "pn_io.error_decode", "error_code1": "pn_io.error_code1",
    "error_code2": "pn_io.error_code2",
}


def number(text):
    return {"True": "0x1", "False": "0x0"}.get(text) or hex(int(text, 0))


def main():
    with open(HERE / "scapy-alarm.txt", "w") as out:
        out.write("# Made by alarm.py with scapy 2.8.0: `name hex`, the bytes after the frame ID, or the data of a record.\n")
        for name, (_, octets) in frames.items():
            out.write(f"{name} {octets.hex()}\n")
        for name, block in records.items():
            out.write(f"{name} {bytes(block).hex()}\n")
    with tempfile.TemporaryDirectory() as scratch:
        pcap = f"{scratch}/alarm.pcap"
        wrpcap(pcap, [Ether(dst="02:00:00:00:00:01", src="02:00:00:00:01:00", type=0x8892) /
                      (struct.pack("!H", frame_id) + octets) for frame_id, octets in frames.values()])
        options = [option for field in FIELDS.values() for option in ("-e", field)]
        lines = subprocess.run(["tshark", "-r", pcap, "-T", "fields", *options], check=True, capture_output=True,
                               text=True).stdout.splitlines()
    with open(HERE / "tshark-alarm.txt", "w") as out:
        out.write("# Made by alarm.py: the dissection of the frames of scapy-alarm.txt by tshark 4.0.17, `name field=values`.\n")
        out.write("# tshark -r alarm.pcap -T fields -e pn_io.alarm_type ... (alarm.py lists the fields)\n")
        for name, line in zip(frames, lines, strict=True):
            read = [f"{key}={','.join(number(value) for value in values.split(','))}"
                    for key, values in zip(FIELDS, line.split("\t"), strict=True) if values]
            out.write(" ".join([name, *read]) + "\n")


main()
