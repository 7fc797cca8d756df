"""Two peers with each other: the controller profinet-py and the device pnio (its example typed_bringup with a diagnosis).

    python peer_pair.py

The controller requests RT class 1, the device supports frame ids of class 2 only: two fields of the Connect are changed on their way,
and no other octet of this recording is ours. Discovery, a connection for records alone that this device refuses, a cyclic session
with inputs, outputs, a diagnosis alarm and I&M0, and release.
"""

from profinet import dcp, rpc
from profinet.cyclic import CyclicController
from profinet.exceptions import RPCConnectionError
from profinet.protocol import PNInM0
from profinet.rpc import IOCRSetup, IOSlot
from profinet.rt import build_iocr_configs
from profinet.util import ethernet_socket, get_mac, s2mac

from common import *

CYCLE_MS, WATCHDOG = 32, 50
SLOTS = [IOSlot(slot=0, subslot=subslot, module_ident=1, submodule_ident=ident) for subslot, ident in
         ((1, 1), (0x8000, 0x8000), (0x8001, 0x8001))]
SLOTS += [IOSlot(slot=slot, subslot=1, module_ident=0x100 + slot, submodule_ident=1, input_length=inputs, output_length=outputs)
          for slot, inputs, outputs in ((1, 64, 0), (2, 4, 0), (3, 0, 64), (4, 0, 4))]


def in_class_2(build):
    """Makes the blocks of a connection of cyclic data request RT class 2 and, for the inputs, a frame id of that class."""
    def changed(**words):
        block = bytearray(build(**words))
        block[12:16] = (2).to_bytes(4, "big")
        if words["iocr_type"] == 1:
            block[18:20] = (0x8001).to_bytes(2, "big")
        return bytes(block)
    return changed


def main():
    wire, own = ethernet_socket(INTERFACE, 3), get_mac(INTERFACE)
    device = rpc.get_station_info(wire, own, DEVICE_NAME, strict_xid=True)
    check("identify: type, address, ids", (device.device_type, device.ip, device.vendor_id, device.device_id),
          ("pnio sample device", DEVICE_IP, 0xFFFF, 0x0001))
    refused = "it was not refused"
    with rpc.RPCCon(device) as connection:
        try:
            connection.connect(own)
        except RPCConnectionError as error:
            # Its message has the octets of the PNIO status the wrong way round.
            refused = str(error).partition("[")[2].rstrip("]")
    check("a connection for records alone is refused with DB 81 04 ..", refused, "ErrorCode1=0x81, ErrorCode2=0xDB")
    time.sleep(0.5)

    setup = IOCRSetup(slots=SLOTS, reduction_ratio=CYCLE_MS, watchdog_factor=WATCHDOG, data_hold_factor=WATCHDOG)
    connection = rpc.RPCCon(device)
    connection._build_iocr_block = in_class_2(connection._build_iocr_block)
    result = connection.connect(own, iocr_setup=setup)
    alarms, received = connection.create_alarm_listener(INTERFACE), []
    alarms.add_callback(received.append)
    alarms.start()
    connection.prm_end()
    ready = connection.application_ready(timeout=10)
    check("application ready", (ready[:2].hex(), ready[28:30].hex()), ("0112", "0002"))
    layout = build_iocr_configs(setup.slots, result.input_frame_id, result.output_frame_id, 32, CYCLE_MS, WATCHDOG)
    exchange = CyclicController(INTERFACE, own, s2mac(device.mac), *layout)
    exchange.start()
    exchange.set_output_data(3, 1, bytes(range(64)))
    exchange.set_output_data(4, 1, bytes([0xA5, 0x5A, 0xFF, 0x01]))
    wait_for("inputs mirror the outputs", lambda: (exchange.get_input_data(2, 1) or b"").hex(), "a55aff01")
    wait_for("alarm: one came", lambda: len(received), 1)
    im0 = PNInM0(connection.read(api=0, slot=0, subslot=1, idx=IM0).payload)
    check("I&M0: order code", im0.order_id.decode().strip(" \0"), "PNIO-SAMPLE")
    wait_for("cyclic: goes on", lambda: exchange.stats.frames_received > 60, True)
    exchange.stop()
    alarms.stop()
    connection.close()
    finish()


main()
