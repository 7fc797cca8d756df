"""An IO controller made of scapy, in either byte order, against the served XAC7718.

    python scapy_controller.py CONTROL big|little

DCP identify and Set IP, a full start-up with the record of the user parameters, cyclic data with the sign of life, I&M0, the
parameter access, a record that is not there, a diagnosis alarm with its acknowledgements, and release.
"""

import select
import socket
import struct
import sys
import threading
import time
import uuid

from scapy.all import Dot1Q, Ether, Raw, conf
from scapy.contrib.pnio import PNIORealTime_IOxS, PNIORealTimeCyclicPDU, ProfinetIO
from scapy.contrib.pnio_dcp import DCPDeviceIDBlock, DCPIPBlock, DCPNameOfStationBlock, ProfinetDCP
from scapy.contrib.pnio_rpc import (
    AlarmCRBlockReq, AlarmNotification_Low, ARBlockReq, ExpectedSubmodule, ExpectedSubmoduleAPI, ExpectedSubmoduleBlockReq,
    ExpectedSubmoduleDataDescription, IOCRAPI, IOCRAPIObject, IOCRBlockReq, IODControlReq, IODControlRes, IODReadReq, IODWriteReq,
    PNIOServiceReqPDU, PNIOServiceResPDU)
from scapy.layers.dcerpc import DceRpc4

from common import *

ENDIAN = sys.argv[2]
INTERFACE_UUID = uuid.UUID("dea00001-6c97-11d1-8271-00a02442df7d")
OBJECT = uuid.UUID(f"dea00000-6c97-11d1-8271-0001{DEVICE:04x}{VENDOR:04x}")
CONNECT, RELEASE, READ, WRITE, CONTROL = range(5)
CYCLE_MS, WATCHDOG = 32, 50
INPUT_FRAME_ID, ALARM_REFERENCE = 0xC010, 0x0021
ACCESS_POINT, TELEGRAM = (1, 1), (1, 2)


class Controller:
    """What a controller keeps of one device."""

    def __init__(self):
        self.ar, self.session, self.activity = uuid.uuid4(), 0x1234, uuid.uuid4()
        self.sequence = 0
        self.caller = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.called = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.called.bind((CONTROLLER_IP, 34964))
        for line in (self.caller, self.called):
            line.settimeout(5)
        self.wire = conf.L2socket(iface=INTERFACE)
        self.outputs, self.inputs, self.status, self.alarms, self.transport_acks = [0, 0], b"", None, [], []
        self.alarm_sequence = 0xFFFE
        self.frames, self.running, self.output_frame_id, self.device_alarm = 0, True, None, None

    def call(self, opnum, block):
        """Calls the device and gives the status and the octets of its answer."""
        request = DceRpc4(endian=ENDIAN, ptype=0, flags1=0x20, object=OBJECT, if_id=INTERFACE_UUID, act_id=self.activity,
                          seqnum=self.sequence, opnum=opnum)
        self.sequence += 1
        blocks = b"".join(bytes(one) for one in block)
        body = struct.pack((">" if ENDIAN == "big" else "<") + "5I", 4096, len(blocks), 4096, 0, len(blocks))
        self.caller.sendto(bytes(request / Raw(body + blocks)), (DEVICE_IP, 34964))
        answer = DceRpc4(self.caller.recv(4096))
        if answer.ptype != 2 or answer.seqnum != self.sequence - 1 or PNIOServiceResPDU not in answer:
            return f"packet type {answer.ptype}", b""
        answer = answer[PNIOServiceResPDU]
        return answer.status, b"".join(bytes(one) for one in answer.blocks)

    def record(self, kind, place, index, data=b"", api=ENCODER_API):
        """Writes or reads a record: its status and, of a read, its data."""
        block = kind(ARUUID=self.ar, API=api, slotNumber=place[0], subslotNumber=place[1], index=index, seqNum=self.sequence,
                     recordDataLength=len(data) if kind is IODWriteReq else 4096)
        status, answer = self.call(WRITE if kind is IODWriteReq else READ, [bytes(block)[:64] + data])
        return status, answer[64:]

    def parameter(self, request):
        """The response of the parameter access to a request."""
        status, _ = self.record(IODWriteReq, ACCESS_POINT, PARAMETER_ACCESS, request)
        return self.record(IODReadReq, ACCESS_POINT, PARAMETER_ACCESS)[1] if status == 0 else f"write refused with {status:#x}"

    def command(self, opnum, **command):
        block = IODControlReq(block_type=0x0114 if opnum == RELEASE else 0x0110, ARUUID=self.ar, SessionKey=self.session, **command)
        return self.call(opnum, [block])

    def connect(self):
        """The blocks of a Connect for telegram 81: 12 octets of inputs, 4 of outputs."""
        def place(slot, subslot, offset):
            return IOCRAPIObject(SlotNumber=slot, SubslotNumber=subslot, FrameOffset=offset)

        def iocr(kind, reference, frame_id, *apis):
            return IOCRBlockReq(IOCRType=kind, IOCRReference=reference, IOCRProperties_RTClass=1, FrameID=frame_id, APIs=list(apis),
                                SendClockFactor=32, ReductionRatio=CYCLE_MS, WatchdogFactor=WATCHDOG, DataHoldFactor=WATCHDOG,
                                IOCRMulticastMACAdd="00:00:00:00:00:00")

        def submodule(subslot, ident, **lengths):
            descriptions = [ExpectedSubmoduleDataDescription(DataDescription=kind, SubmoduleDataLength=length, LengthIOCS=1,
                                                             LengthIOPS=1) for kind, length in lengths.values()]
            return ExpectedSubmodule(SubslotNumber=subslot, SubmoduleIdentNumber=ident, DataDescription=descriptions,
                                     SubmoduleProperties_Type=3 if len(lengths) == 2 else 0)

        def module(api, slot, ident, *submodules):
            return ExpectedSubmoduleBlockReq(APIs=[ExpectedSubmoduleAPI(API=api, SlotNumber=slot, ModuleIdentNumber=ident,
                                                                        Submodules=list(submodules))])
        return self.call(CONNECT, [
            ARBlockReq(ARUUID=self.ar, SessionKey=self.session, CMInitiatorMacAdd=CONTROLLER_MAC,
                       CMInitiatorObjectUUID="dea00000-6c97-11d1-8271-000100010001", ARProperties_ParametrizationServer=1,
                       CMInitiatorStationName=b"scapy"),
            iocr(1, 1, INPUT_FRAME_ID, IOCRAPI(API=0, IODataObjects=[place(0, 1, 0)]),
                 IOCRAPI(API=ENCODER_API, IODataObjects=[place(1, 1, 1), place(1, 2, 2)], IOCSs=[place(1, 2, 15)])),
            iocr(2, 2, 0xFFFF, IOCRAPI(API=0, IOCSs=[place(0, 1, 5)]),
                 IOCRAPI(API=ENCODER_API, IODataObjects=[place(1, 2, 0)], IOCSs=[place(1, 1, 6), place(1, 2, 7)])),
            AlarmCRBlockReq(LocalAlarmReference=ALARM_REFERENCE),
            module(0, 0, DAP_IDENT, submodule(1, 1, inputs=(1, 0))),
            module(ENCODER_API, 1, 1, submodule(1, 2, inputs=(1, 0)), submodule(2, TELEGRAM_81, inputs=(1, 12), outputs=(2, 4)))])

    def application_ready(self):
        """Takes the call ApplicationReady of the device, in its byte order, and answers it."""
        octets, caller = self.called.recvfrom(4096)
        call = DceRpc4(octets)
        order = ">" if call.endian == 0 else "<"
        block = IODControlReq(octets[100:132])
        done = bytes(IODControlRes(block_type=0x8112, ARUUID=self.ar, SessionKey=self.session))
        head = DceRpc4(endian=call.endian, ptype=2, flags1=0x0A, object=call.object, if_id=call.if_id, act_id=call.act_id,
                       server_boot=1, seqnum=call.seqnum, opnum=call.opnum)
        self.called.sendto(bytes(head / Raw(struct.pack(order + "5I", 0, 32, 32, 0, 32) + done)), caller)
        return (call.opnum, block.block_type, block.ARUUID, block.SessionKey, block.ControlCommand_ApplicationReady)

    def send(self, frame_id, payload, priority):
        tag = Dot1Q(prio=priority, vlan=0, type=0x8892)
        self.wire.send(Ether(dst=DEVICE_MAC, src=CONTROLLER_MAC) / tag / ProfinetIO(frameID=frame_id) / payload)

    def receive(self):
        """The next frame, or nothing when none comes for a while."""
        return self.wire.recv() if select.select([self.wire], [], [], 0.2)[0] else None

    def provide(self):
        """Sends the outputs cycle by cycle, with the sign of life."""
        due, sign = time.monotonic(), 0
        while self.running:
            sign = sign % 15 + 1
            data = struct.pack("!HH", self.outputs[0] | sign << 12, self.outputs[1])
            good = [PNIORealTime_IOxS(dataState=1)] * 4
            self.send(self.output_frame_id, PNIORealTimeCyclicPDU(data=[Raw(data), *good], padding=bytes(32),
                                                                  cycleCounter=int(due * 32_000) & 0xFFFF), 6)
            due += CYCLE_MS / 1000
            time.sleep(max(0, due - time.monotonic()))

    def listen(self):
        """Takes inputs and alarms of the device; acknowledges alarms."""
        while self.running:
            frame = self.receive()
            if frame is None or frame.src != DEVICE_MAC or ProfinetIO not in frame:
                continue
            octets = bytes(frame[ProfinetIO])
            if frame[ProfinetIO].frameID == INPUT_FRAME_ID:
                self.inputs, self.status = octets[4:16], (octets[2], octets[3], octets[16], octets[17], octets[44], octets[45])
                self.frames += 1
            elif frame[ProfinetIO].frameID in (0xFC01, 0xFE01):
                self.alarm(frame[ProfinetIO].frameID, octets[2:])

    def alarm(self, frame_id, octets):
        kind, send_sequence = octets[4] & 0x0F, struct.unpack("!H", octets[6:8])[0]
        if kind == 3:
            self.transport_acks.append(struct.unpack("!H", octets[8:10])[0])
        if kind != 1:
            return
        notification = AlarmNotification_Low(octets[12:12 + int.from_bytes(octets[10:12], "big")])
        item = notification.AlarmPayload[0]
        self.alarms.append((notification.AlarmType, notification.API, notification.SlotNumber, notification.SubslotNumber,
                            item.ChannelErrorType))

        def rta(kind, flags, part):
            head = struct.pack("!HHBBHHH", self.device_alarm, ALARM_REFERENCE, 0x10 | kind, flags, self.alarm_sequence,
                               send_sequence, len(part))
            self.send(frame_id, Raw((head + part).ljust(42, b"\0")), 5)
        rta(3, 0x01, b"")
        self.alarm_sequence = 0 if self.alarm_sequence == 0xFFFF else self.alarm_sequence + 1
        rta(1, 0x11, struct.pack("!HHBB", 0x8002, 18, 1, 0) + octets[18:28] + octets[36:38] + bytes(4))


def dcp(controller):
    """Finds the device and gives it its address."""
    def ask(destination, frame_id, **fields):
        request = ProfinetDCP(service_type=0, xid=0x01020304, **fields)
        controller.wire.send(Ether(dst=destination, src=CONTROLLER_MAC, type=0x8892) / ProfinetIO(frameID=frame_id) / request)
        end = time.monotonic() + 5
        while time.monotonic() < end:
            frame = controller.receive()
            if frame is not None and frame.dst == CONTROLLER_MAC and ProfinetDCP in frame and frame[ProfinetDCP].xid == 0x01020304:
                return frame
        return Ether()
    found = ask("01:0e:cf:00:00:00", 0xFEFE, service_id=5, option=255, sub_option=255, dcp_block_length=0, dcp_data_length=4,
                reserved=1)
    check("identify: the device answers", found.src, DEVICE_MAC)
    blocks = found[ProfinetDCP].dcp_blocks
    ident = next((block for block in blocks if isinstance(block, DCPDeviceIDBlock)), None)
    name = next((block for block in blocks if isinstance(block, DCPNameOfStationBlock)), None)
    check("identify: vendor and device", ident and (ident.vendor_id, ident.device_id), (VENDOR, DEVICE))
    check("identify: name", name and name.name_of_station, DEVICE_NAME.encode())
    answer = ask(DEVICE_MAC, 0xFEFD, service_id=4, option=1, sub_option=2, dcp_block_length=14, dcp_data_length=18, block_qualifier=0,
                 ip=DEVICE_IP, netmask=NETMASK, gateway=GATEWAY)
    check("set IP: done", (answer.src, bytes(answer[ProfinetDCP])[10:18].hex()), (DEVICE_MAC, "0504000301020000"))


def main():
    one = Controller()
    dcp(one)

    check("connect: status", (connected := one.connect())[0], 0)
    answer = connected[1]
    blocks = {}
    while len(answer) >= 4:
        length = 4 + int.from_bytes(answer[2:4], "big")
        blocks.setdefault(answer[:2].hex(), []).append(answer[:length])
        answer = answer[length:]
    check("connect: blocks of the answer", sorted(blocks), ["8101", "8102", "8103"])
    frame_ids = {int.from_bytes(block[6:8], "big"): int.from_bytes(block[10:12], "big") for block in blocks["8102"]}
    check("connect: frame id of the inputs", frame_ids.get(1), INPUT_FRAME_ID)
    check("connect: frame id of the outputs is of RT class 1", 0xC000 <= frame_ids.get(2, 0) <= 0xF7FF, True)
    one.output_frame_id, one.device_alarm = frame_ids[2], int.from_bytes(blocks["8103"][0][8:10], "big")
    threads = [threading.Thread(target=run, daemon=True) for run in (one.provide, one.listen)]
    for thread in threads:
        thread.start()

    check("write of the user parameters", one.record(IODWriteReq, ACCESS_POINT, USER_PARAMETERS, START_RECORD)[0], 0)
    status, block = one.command(CONTROL, ControlCommand_PrmEnd=1)
    check("end of parameters", (status, block[:2].hex(), block[28:30].hex()), (0, "8110", "0008"))
    check("application ready", one.application_ready(), (CONTROL, 0x0112, one.ar, one.session, 1))

    good = (0x80, 0x80, 0x80, 0x80, 0x35, 0)
    wait_for("cyclic: IOPS, IOCS, data status and transfer status", lambda: one.status, good)
    one.outputs = [1 << 10, 0]
    check("stand: shaft to 1000", stand("shaft counts 1000"), "ok")
    wait_for("cyclic: G1_XIST1 is 1000", lambda: one.inputs[4:8].hex(), "000003e8")
    check("stand: shaft to 262143", stand("shaft counts 262143"), "ok")
    wait_for("cyclic: G1_XIST1 is 262143", lambda: one.inputs[4:8].hex(), "0003ffff")
    signs = set()
    wait_for("cyclic: the sign of life of the device takes each value from 1 to 15",
             lambda: (signs.add(one.inputs[0] >> 4), sorted(signs))[1], list(range(1, 16)))

    status, im0 = one.record(IODReadReq, ACCESS_POINT, IM0)
    check("I&M0: block, vendor and order code", (status, im0[:8].hex(), im0[8:28].decode().rstrip()),
          (0, "002000380100" + f"{VENDOR:04x}", ORDER_ID))
    check("0xB02E: P964", one.parameter(read_request(1, 964, 6)), bytes([1, 1, 1, 1, 0x42, 6]) + struct.pack("!6H", *P964))
    check("0xB02E: change of P65000", one.parameter(change_request(2, 65000, 5000)).hex(), "02020101")
    check("0xB02E: P65000 is 5000", one.parameter(read_request(3, 65000)).hex(), "030101014301" + "00001388")
    check("0xB02E: an unknown parameter", one.parameter(read_request(4, 999)).hex(), "04810101" + "4401" + "0000")
    one.outputs = [1 << 10, 1 << 12]
    wait_for("preset: acknowledged", lambda: one.inputs[2] >> 4 & 1, 1)
    wait_for("preset: G1_XIST1 is 5000", lambda: one.inputs[4:8].hex(), "00001388")
    one.outputs = [1 << 10, 0]
    wait_for("preset: done", lambda: one.inputs[2] >> 4 & 1, 0)
    status, data = one.record(IODReadReq, ACCESS_POINT, 0x7FFF)
    check("a record that is not there", (f"{status:08x}", data), ("de80b000", b""))

    check("stand: memory fault", stand("fault memory present"), "ok")
    wait_for("alarm: diagnosis of the memory", lambda: one.alarms[:1], [(1, ENCODER_API, 1, 1, 0x9000)])
    wait_for("alarm: the device acknowledges our acknowledgement", lambda: one.transport_acks[:1], [0xFFFF])
    check("stand: no memory fault", stand("fault memory absent"), "ok")
    one.outputs = [1 << 10, 1 << 15]
    wait_for("error: acknowledgement in process", lambda: one.inputs[2] >> 3 & 1, 1)
    one.outputs = [1 << 10, 0]
    wait_for("error: no longer shown", lambda: one.inputs[2:4].hex(), "0000")
    wait_for("alarm: the diagnosis disappears", lambda: one.alarms[1:2], [(12, ENCODER_API, 1, 1, 0x9000)])
    wait_for("alarm: the second acknowledgement too", lambda: one.transport_acks[1:2], [0])

    wait_for("cyclic: goes on", lambda: one.frames > 60, True)
    status, block = one.command(RELEASE, ControlCommand_Release=1)
    check("release", (status, block[:2].hex(), block[28:30].hex()), (0, "8114", "0008"))
    released = one.frames
    time.sleep(0.5)
    check("release: at most one frame of inputs after it", one.frames - released <= 1, True)
    one.running = False
    finish()


main()
