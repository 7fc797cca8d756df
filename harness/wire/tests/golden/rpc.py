"""Builds RPC PDUs with scapy and prints them as lines `name hex`; prints their dissection by tshark, and that of captures.

    pip install scapy==2.8.0
    python3 rpc.py > scapy-rpc.txt
    python3 rpc.py tshark > tshark-rpc.txt                        (needs tshark 4.0)
    python3 rpc.py captures FOLDER > tshark-rpc-captures.txt      (likewise)

The PDUs are payloads of UDP datagrams. For some bodies scapy has no class (fack, cancel, reject): they are packed here field by
field from C706, so only tshark's dissection of them is independent.
"""

import struct
import subprocess
import sys
import tempfile
import uuid

from scapy.all import IP, UDP, Ether, Raw, wrpcap
from scapy.contrib.pnio_rpc import (
    AlarmCRBlockReq, AlarmCRBlockRes, ARBlockReq, ARBlockRes, ExpectedSubmodule, ExpectedSubmoduleAPI,
    ExpectedSubmoduleBlockReq, ExpectedSubmoduleDataDescription, IOCRAPI, IOCRAPIObject, IOCRBlockReq, IOCRBlockRes,
    IODControlReq, IODControlRes, IODReadReq, IODReadRes, IODWriteMultipleReq, IODWriteMultipleRes, IODWriteReq,
    IODWriteRes, PNIOServiceReqPDU, PNIOServiceResPDU,
)
from scapy.layers.dcerpc import DceRpc4, NDRPointer
from scapy.layers.msrpce.ept import prot_and_addr_t, protocol_tower_t
from scapy.layers.msrpce.raw.ept import (
    RPC_IF_ID, UUID, ept_entry_t, ept_lookup_Request, ept_lookup_Response, twr_p_t,
)

AR = "12345678-9abc-def0-1122-334455667788"
OBJECT = "dea00000-6c97-11d1-8271-000107d2010c"
DEVICE, CONTROLLER = (f"dea0000{n}-6c97-11d1-8271-00a02442df7d" for n in (1, 2))
MAPPER = "e1af8308-5d1f-11c9-91a4-08002b14a0fa"
ACTIVITY = "00112233-4455-6677-8899-aabbccddeeff"
MAC, DEVICE_MAC = "02:00:00:00:00:01", "02:00:00:00:01:00"
BIG, LITTLE = 0, 1
pdus = []


def rpc(name, ptype, body, endian=BIG, **fields):
    fields = dict(dict(object=OBJECT, if_id=DEVICE, act_id=ACTIVITY, seqnum=7, flags1=0x20, serial_hi=0x12, serial_lo=0x34), **fields)
    pdus.append((name, bytes(DceRpc4(ptype=ptype, endian=endian, **fields) / body)))


def request(name, opnum, *blocks, **fields):
    rpc(name, 0, PNIOServiceReqPDU(args_max=4096, max_count=4096, blocks=list(blocks)), opnum=opnum, **fields)


def response(name, opnum, *blocks, status=0, **fields):
    body = PNIOServiceResPDU(status=status, max_count=4096, blocks=list(blocks))
    rpc(name, 2, body, opnum=opnum, **dict(dict(flags1=0x0A, server_boot=0x01020304), **fields))


def api(objects, iocs):
    lists = [[IOCRAPIObject(SlotNumber=s, SubslotNumber=u, FrameOffset=o) for s, u, o in rows] for rows in (objects, iocs)]
    return IOCRAPI(API=0, IODataObjects=lists[0], IOCSs=lists[1])


def submodule(subslot, ident, kind, *lengths):
    rows = [ExpectedSubmoduleDataDescription(DataDescription=d, SubmoduleDataLength=n, LengthIOCS=1, LengthIOPS=1)
            for d, n in lengths]
    return ExpectedSubmodule(SubslotNumber=subslot, SubmoduleIdentNumber=ident, SubmoduleProperties_Type=kind,
                             DataDescription=rows)


def connect_blocks():
    return [
        ARBlockReq(ARType=1, ARUUID=AR, SessionKey=2, CMInitiatorMacAdd=MAC, CMInitiatorObjectUUID=OBJECT,
                   ARProperties_StartupMode=1, ARProperties_ParametrizationServer=1, ARProperties_State=1,
                   CMInitiatorActivityTimeoutFactor=600, CMInitiatorStationName="controller"),
        IOCRBlockReq(IOCRType=1, IOCRReference=1, IOCRProperties_RTClass=2, DataLength=40, FrameID=0x8001,
                     SendClockFactor=32, ReductionRatio=2, WatchdogFactor=10, DataHoldFactor=10,
                     APIs=[api([(0, 1, 0), (1, 1, 1), (1, 2, 14)], [(1, 2, 27)])]),
        IOCRBlockReq(IOCRType=2, IOCRReference=2, IOCRProperties_RTClass=2, DataLength=40, FrameID=0xFFFF,
                     SendClockFactor=32, ReductionRatio=2, WatchdogFactor=10, DataHoldFactor=10,
                     APIs=[api([(1, 2, 0)], [(0, 1, 5), (1, 1, 6), (1, 2, 7)])]),
        ExpectedSubmoduleBlockReq(APIs=[ExpectedSubmoduleAPI(
            API=0, SlotNumber=0, ModuleIdentNumber=0x00000101, Submodules=[submodule(1, 0x11, 0, (1, 0))])]),
        ExpectedSubmoduleBlockReq(APIs=[ExpectedSubmoduleAPI(
            API=0x3D00, SlotNumber=1, ModuleIdentNumber=0x00000202,
            Submodules=[submodule(1, 0x21, 1, (1, 12)), submodule(2, 0x22, 3, (1, 12), (2, 4))])]),
        AlarmCRBlockReq(RTATimeoutFactor=1, RTARetries=3, LocalAlarmReference=5, MaxAlarmDataLength=200),
    ]


def odd_connect_blocks():
    """Adjacent fields have different values, to detect swapped fields."""
    place = [IOCRAPIObject(SlotNumber=n, SubslotNumber=n + 1, FrameOffset=n + 2) for n in (0x1101, 0x2202, 0x3303)]
    rows = [ExpectedSubmoduleDataDescription(DataDescription=n, SubmoduleDataLength=0x50 + n, LengthIOCS=n + 2,
                                             LengthIOPS=n + 4) for n in (1, 2)]
    return [
        ARBlockReq(ARType=6, ARUUID=AR, SessionKey=0x1234, CMInitiatorMacAdd=MAC, CMInitiatorObjectUUID=OBJECT,
                   ARProperties_PullModuleAlarmAllowed=1, ARProperties_StartupMode=0, ARProperties_reserved_2=0x421,
                   ARProperties_AcknowledgeCompanionAR=1, ARProperties_CompanionAR=2, ARProperties_DeviceAccess=1,
                   ARProperties_SupervisorTakeoverAllowed=1, ARProperties_State=1,
                   CMInitiatorActivityTimeoutFactor=0x0258, CMInitiatorUDPRTPort=0x8893, CMInitiatorStationName="supervisor-1"),
        IOCRBlockReq(IOCRType=2, IOCRReference=0x0304, LT=0x0800, IOCRProperties_RTClass=3, IOCRProperties_reserved1=0x81,
                     DataLength=0x0123, FrameID=0x8765, SendClockFactor=0x21, ReductionRatio=0x22, Phase=0x23, Sequence=0x24,
                     FrameSendOffset=0x01020304, WatchdogFactor=0x25, DataHoldFactor=0x26, IOCRTagHeader_IOUserPriority=5,
                     IOCRTagHeader_IOCRVLANID=0x123, IOCRMulticastMACAdd="01:0e:cf:00:01:02",
                     APIs=[IOCRAPI(API=0x3D00, IODataObjects=place[:2], IOCSs=place[2:]), IOCRAPI(API=0x3D01)]),
        ExpectedSubmoduleBlockReq(APIs=[
            ExpectedSubmoduleAPI(API=n, SlotNumber=n + 1, ModuleIdentNumber=0x10000 + n, ModuleProperties=n + 2, Submodules=[
                ExpectedSubmodule(SubslotNumber=n + 3, SubmoduleIdentNumber=0x20000 + n, SubmoduleProperties_Type=3,
                                  SubmoduleProperties_SharedInput=1, SubmoduleProperties_DiscardIOXS=1,
                                  DataDescription=rows)]) for n in (0x100, 0x200)]),
        AlarmCRBlockReq(AlarmCRProperties_Reserved2=2, RTATimeoutFactor=0x31, RTARetries=0x32, LocalAlarmReference=0x33,
                        MaxAlarmDataLength=0x234, AlarmCRTagHeaderHigh=0xC001, AlarmCRTagHeaderLow=0xA002),
    ]


def block(kind, body):
    """A block for which scapy has no class."""
    return Raw(struct.pack(">HHBB", kind, len(body) + 2, 1, 0) + body)


def connect_answers():
    return [
        ARBlockRes(ARType=1, ARUUID=AR, SessionKey=2, CMResponderMacAdd=DEVICE_MAC),
        IOCRBlockRes(IOCRType=1, IOCRReference=1, FrameID=0x8001),
        IOCRBlockRes(IOCRType=2, IOCRReference=2, FrameID=0x8000),
        AlarmCRBlockRes(LocalAlarmReference=9, MaxAlarmDataLength=1432),
    ]


def record(index, data=b"", **fields):
    return IODWriteReq(seqNum=3, ARUUID=AR, API=0x3D00, slotNumber=1, subslotNumber=1, index=index, **fields) / Raw(data)


def small_pdus():
    for name, ptype, body, fields in [
        ("ping", 1, b"", {}),
        ("fault", 3, [0x1C010003], {}),
        ("working", 4, b"", {}),
        ("nocall", 5, b"", {}),
        ("reject", 6, [0x1C010002], {}),
        ("ack", 7, b"", {}),
        ("cancel", 8, [0, 5], {}),
        ("cancel_ack", 10, [0, 5, 1], {}),
    ]:
        for order, endian in (">", BIG), ("<", LITTLE):
            octets = struct.pack(f"{order}{len(body)}I", *body) if body else b""
            rpc(f"{name}_{'little' if endian else 'big'}", ptype, Raw(octets), endian, flags1=0, opnum=2, **fields)
    for order, endian in (">", BIG), ("<", LITTLE):
        octets = struct.pack(f"{order}BBHIIHHII", 0, 0, 8, 1464, 1464, 2, 2, 0x5, 0x80000000)
        rpc(f"fack_{'little' if endian else 'big'}", 9, Raw(octets), endian, flags1=0, opnum=3, fragnum=1)


def endpoint_mapper():
    for endian, word in (BIG, "big"), (LITTLE, "little"):
        ndr = dict(ndr64=False, ndrendian="little" if endian else "big")
        body = ept_lookup_Request(inquiry_type=0, object=NDRPointer(referent_id=1, value=UUID(**ndr), **ndr),
                                  Ifid=NDRPointer(referent_id=2, value=RPC_IF_ID(**ndr), **ndr), vers_option=1,
                                  max_ents=1, **ndr)
        rpc(f"lookup_request_{word}", 0, Raw(bytes(body)), endian, if_id=MAPPER, object=str(uuid.UUID(int=0)), if_vers=3,
            opnum=2, act_id=ACTIVITY)
        tower = bytes(protocol_tower_t(floors=[
            prot_and_addr_t(lhs_length=19, protocol_identifier=0xD, uuid=uuid.UUID(DEVICE), version=1, rhs_length=2, rhs=0),
            prot_and_addr_t(lhs_length=19, protocol_identifier=0xD, uuid=uuid.UUID("8a885d04-1ceb-11c9-9fe8-08002b104860"),
                            version=2, rhs_length=2, rhs=0),
            prot_and_addr_t(lhs_length=1, protocol_identifier=0xA, rhs_length=2, rhs=0),
            prot_and_addr_t(lhs_length=1, protocol_identifier=0x8, rhs_length=2, rhs=34964),
            prot_and_addr_t(lhs_length=1, protocol_identifier=0x9, rhs_length=4, rhs="192.168.0.10"),
        ]))
        annotation = b"encoder".ljust(25) + b" " + b"ORDER-1".ljust(20) + b" " + b"    1" + b" " + b"V  1  2  3" + b"\0"
        entry = ept_entry_t(object=UUID(Data1=0xDEA00000, Data2=0x6C97, Data3=0x11D1,
                                        Data4=bytes.fromhex("8271000107d2010c"), **ndr),
                            tower=NDRPointer(referent_id=3, value=twr_p_t(tower_octet_string=tower, **ndr), **ndr),
                            annotation=annotation, **ndr)
        body = ept_lookup_Response(num_ents=1, entries=[entry], status=0, **ndr)
        rpc(f"lookup_response_{word}", 2, Raw(bytes(body)), endian, if_id=MAPPER, object=str(uuid.UUID(int=0)), if_vers=3,
            opnum=2, flags1=0x0A)


for endian, word in (BIG, "big"), (LITTLE, "little"):
    request(f"connect_request_{word}", 0, *connect_blocks(), endian=endian)
    response(f"connect_response_{word}", 0, *connect_answers(), endian=endian)
    response(f"connect_refused_{word}", 0, status=0xDB814004, endian=endian)
    request(f"write_{word}", 3, record(0xB02E, bytes(range(10))), endian=endian)
    answer = IODWriteRes(seqNum=3, ARUUID=AR, API=0x3D00, slotNumber=1, subslotNumber=1, index=0xB02E, status=0xDF80B600)
    response(f"write_response_{word}", 3, answer, status=0xDF80B600, endian=endian)
    request(f"write_multiple_{word}", 3,
            IODWriteMultipleReq(seqNum=4, ARUUID=AR, blocks=[record(0x1000, b"\1\2\3"), record(0x1001, b"\4\5\6\7\x08")]),
            endian=endian)
    inner = [IODWriteRes(seqNum=3, ARUUID=AR, API=0x3D00, slotNumber=1, subslotNumber=1, index=i, status=s)
             for i, s in ((0x1000, 0), (0x1001, 0xDF80B106))]
    response(f"write_multiple_response_{word}", 3, IODWriteMultipleRes(seqNum=4, ARUUID=AR, blocks=inner), endian=endian)
    read = dict(seqNum=5, ARUUID=AR, API=0x3D00, slotNumber=1, subslotNumber=1, index=0xB02E)
    request(f"read_{word}", 2, IODReadReq(recordDataLength=240, **read), endian=endian)
    response(f"read_response_{word}", 2, IODReadRes(additionalValue1=1, **read) / Raw(bytes(range(12))), endian=endian)
    response(f"read_refused_{word}", 2, IODReadRes(**read), status=0xDE80B500, endian=endian)
    request(f"read_implicit_{word}", 5, IODReadReq(recordDataLength=64, index=0xAFF0, slotNumber=0, subslotNumber=1,
                                                   RWPadding=uuid.UUID(AR).bytes + b"\0" * 8), endian=endian)
    control = dict(ARUUID=AR, SessionKey=2)
    request(f"prm_end_{word}", 4, IODControlReq(ControlCommand_PrmEnd=1, **control), endian=endian)
    response(f"prm_end_done_{word}", 4, IODControlRes(**control), endian=endian)
    request(f"application_ready_{word}", 4, IODControlReq(ControlCommand_ApplicationReady=1, **control), endian=endian,
            if_id=CONTROLLER)
    request(f"plug_prm_end_{word}", 4, IODControlReq(ControlCommand_PrmEnd=1, AlarmSequenceNumber=9, **control), endian=endian)
    request(f"release_{word}", 1, IODControlReq(ControlCommand_Release=1, **control), endian=endian)
    response(f"release_done_{word}", 1, IODControlRes(block_type=0x8114, **control), endian=endian)
    request(f"connect_odd_{word}", 0, *odd_connect_blocks(), endian=endian, ihint=0x1122, ahint=0x3344,
            server_boot=0x0A0B0C0D, fragnum=0)
    response(f"connect_odd_response_{word}", 0,
             ARBlockRes(ARType=6, ARUUID=AR, SessionKey=0x1234, CMResponderMacAdd=DEVICE_MAC, CMResponderUDPRTPort=0x8894),
             IOCRBlockRes(IOCRType=2, IOCRReference=0x0304, FrameID=0x8000), AlarmCRBlockRes(LocalAlarmReference=9,
             MaxAlarmDataLength=0x345), endian=endian)
    server = b"encoder-under-test"
    response(f"connect_server_{word}", 0, ARBlockRes(ARType=1, ARUUID=AR, SessionKey=2, CMResponderMacAdd=DEVICE_MAC),
             block(0x8106, struct.pack(">H", len(server)) + server + b"\0\0"), block(0x8107, struct.pack(">H", 34965)),
             endian=endian)
    request(f"connect_prm_server_{word}", 0, connect_blocks()[0], block(0x0105, uuid.UUID(OBJECT).bytes + struct.pack(
            ">IHH", 0x01020304, 0x258, 10) + b"prm-server"), block(0x0115, struct.pack(">H", 34966)), endian=endian)
    response(f"read_odd_{word}", 2, IODReadRes(seqNum=0x55, ARUUID=AR, API=0x3D00, slotNumber=0x11, subslotNumber=0x12,
             index=0x8000, additionalValue1=0x61, additionalValue2=0x62) / Raw(b"abc"), endian=endian)
small_pdus()
endpoint_mapper()

FIELDS = """dcerpc.pkt_type dcerpc.opnum dcerpc.drep.byteorder dcerpc.dg_seqnum dcerpc.dg_act_id dcerpc.obj_id dcerpc.dg_if_id
dcerpc.dg_frag_len dcerpc.dg_frag_num dcerpc.dg_if_ver dcerpc.dg_ahint dcerpc.dg_ihint dcerpc.dg_serial_hi dcerpc.dg_serial_lo dcerpc.dg_status dcerpc.fack_window_size dcerpc.fack_serial_num
dcerpc.fack_selack dcerpc.dg_cancel_id pn_io.status pn_io.args_max pn_io.args_len pn_io.block_type pn_io.ar_type pn_io.ar_uuid
pn_io.session_key pn_io.cminitiator_mac_add pn_io.cminitiator_uuid pn_io.ar_properties pn_io.cminitiator_udprtport
pn_io.cminitiator_activitytimeoutfactor pn_io.cminitiator_station_name
pn_io.cmresponder_macadd pn_io.cmresponder_udprtport
pn_io.iocr_type pn_io.iocr_reference pn_io.lt pn_io.iocr_properties pn_io.phase pn_io.sequence pn_io.frame_send_offset
pn_io.iocr_tag_header pn_io.iocr_multicast_mac_add pn_io.alarmcr_type pn_io.alarmcr_properties pn_io.alarmcr_tagheaderhigh
pn_io.alarmcr_tagheaderlow pn_io.module_properties pn_io.submodule_properties pn_io.data_description pn_io.length_iocs
pn_io.length_iops pn_io.seq_number pn_io.control_alarm_sequence_number pn_io.add_val2
pn_io.data_length pn_io.frame_id pn_io.send_clock_factor pn_io.reduction_ratio pn_io.watchdog_factor pn_io.data_hold_factor
pn_io.api pn_io.slot_nr pn_io.subslot_nr pn_io.io_data_object.frame_offset pn_io.iocs_frame_offset
pn_io.module_ident_number pn_io.submodule_ident_number pn_io.submodule_data_length pn_io.rta_timeoutfactor pn_io.rta_retries
pn_io.localalarmref pn_io.maxalarmdatalength pn_io.index pn_io.record_data_length pn_io.error_code pn_io.error_decode
pn_io.error_code1 pn_io.error_code2 pn_io.control_command pn_io.add_val1 pn_io.target_ar_uuid epm.uuid epm.proto.udp_port
epm.proto.ip epm.annotation""".split()


def known_fields():
    known = subprocess.run(["tshark", "-G", "fields"], capture_output=True, text=True, check=True).stdout
    known = {line.split("\t")[2] for line in known.splitlines() if line.startswith("F")}
    return [field for field in FIELDS if field in known]


def read(file, *selection):
    fields = known_fields()
    command = ["tshark", "--disable-protocol", "wg", "-r", file, *selection, "-T", "fields", "-E", "separator=|", "-e", "frame.number"]
    command += [part for field in fields for part in ("-e", field)]
    for line in subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines():
        number, *values = line.split("|")
        yield number, [f"{f}={v.replace(' ', '_')}" for f, v in zip(fields, values) if v]


def tshark():
    with tempfile.NamedTemporaryFile(suffix=".pcap") as file:
        wrpcap(file.name, [Ether(src=MAC, dst=DEVICE_MAC) / IP(src="192.168.0.1", dst="192.168.0.10")
                           / UDP(sport=34964, dport=34964) / Raw(pdu) for _, pdu in pdus])
        for (name, _), (_, fields) in zip(pdus, read(file.name)):
            print(name, *fields)


def captures(folder):
    """The first PDU of each kind and set of block types; fragments are omitted, because tshark dissects the whole body in the last one."""
    kinds = set()
    for file in ("one-ar-life.pcapng", "record-reads.pcapng", "implicit-reads-ns.pcapng", "office-noise-versamax.pcap",
                 "merged-many-devices.pcapng"):
        for number, fields in read(f"{folder}/{file}", "-Y", "dcerpc && dcerpc.dg_flags1_frag == 0"):
            kind = tuple(frozenset(f.replace("=", ",").split(",")) for f in fields if f.split("=")[0] in KIND)
            if kind not in kinds:
                print(f"{file}:{number}", *fields)
            kinds.add(kind)


KIND = ("dcerpc.pkt_type", "dcerpc.opnum", "dcerpc.drep.byteorder", "pn_io.block_type", "pn_io.error_code1")
if sys.argv[1:] == ["tshark"]:
    print("# Dissection of the PDUs of scapy-rpc.txt by tshark 4.0.17, `name field=values`; made by: python3 rpc.py tshark > tshark-rpc.txt")
    print("# tshark --disable-protocol wg -r FILE -T fields -e dcerpc.pkt_type ... (rpc.py lists the fields)")
    tshark()
elif sys.argv[1:2] == ["captures"]:
    print("# Dissection of some packets of the captures by tshark 4.0.17, `file:packet field=values`; made by:")
    print("# python3 rpc.py captures FOLDER > tshark-rpc-captures.txt, where FOLDER is captures/profinet of the shared folder")
    captures(sys.argv[2])
else:
    print("# RPC PDUs built with scapy 2.8.0; made by: python3 rpc.py > scapy-rpc.txt")
    print("# One payload of a UDP datagram per line: its name, then its bytes.")
    for name, pdu in pdus:
        print(name, pdu.hex())
