"""profinet-py, a controller of others, against the served XAC7718.

    python profinet_py.py CONTROL

Discovery by its library and by its command line, records on its connection for records alone (AR type 6), and a cyclic session.
Its parser of the PNIO status swaps octets, so an error is compared by the raw octets that came.
"""

import subprocess
import sys
from pathlib import Path

from profinet import dcp, rpc
from profinet.cyclic import CyclicController
from profinet.exceptions import PNIOError
from profinet.protocol import PNInM0
from profinet.rpc import IOCRSetup, IOSlot
from profinet.rt import build_iocr_configs
from profinet.util import ethernet_socket, get_mac, s2mac

from common import *

CYCLE_MS, WATCHDOG = 32, 50
SLOTS = [IOSlot(slot=0, subslot=1, module_ident=DAP_IDENT, submodule_ident=1),
         IOSlot(slot=1, subslot=1, module_ident=1, submodule_ident=2, api=ENCODER_API),
         IOSlot(slot=1, subslot=2, input_length=12, output_length=4, module_ident=1, submodule_ident=TELEGRAM_81, api=ENCODER_API)]


def command_line(*words):
    """What its command line prints."""
    program = Path(sys.executable).with_name("profinet")
    done = subprocess.run([program, "-i", INTERFACE, "-t", "2", *words], capture_output=True, text=True, timeout=30)
    return done.stdout if done.returncode == 0 else f"exit status {done.returncode}: {done.stderr}"


def find(wire, own):
    dcp.send_discover(wire, own)
    found = {device.mac: device for device in
             (dcp.DCPDeviceDescription(mac, blocks) for mac, blocks in dcp.read_response(wire, own, timeout_sec=2).items())}
    check("discover: one device", list(found), [DEVICE_MAC])
    device = found.get(DEVICE_MAC)
    check("discover: name, type, address", device and (device.name, device.device_type, device.ip, device.netmask),
          (DEVICE_NAME, STATION_TYPE, DEVICE_IP, NETMASK))
    check("discover: vendor, device, role", device and (device.vendor_id, device.device_id, device.device_roles),
          (VENDOR, DEVICE, ["IO-Device"]))
    printed = command_line("discover")
    check("profinet discover: finds it", [word for word in (DEVICE_NAME, DEVICE_IP, DEVICE_MAC) if word not in printed], [])
    printed = command_line("read-inm0", DEVICE_NAME, "--api", str(ENCODER_API), "--slot", "1", "--subslot", "1")
    check("profinet read-inm0: the order code", ORDER_ID in printed or printed, True)


def text(padded):
    return padded.decode().strip(" \0")


def raw_status(calls, what):
    """The PNIO status, as it came, of a call that the device has to refuse."""
    try:
        what()
    except PNIOError:
        return calls[-1].payload[:4].hex()
    return "no refusal"


def access(device, own):
    """Records on a connection for records alone."""
    with rpc.RPCCon(device) as connection:
        answers, receive = [], connection._send_receive
        connection._send_receive = lambda call: answers.append(receive(call)) or answers[-1]
        connection.connect(own)

        def read(place, index):
            return connection.read(api=ENCODER_API, slot=place[0], subslot=place[1], idx=index).payload

        def parameter(request):
            connection.write(api=ENCODER_API, slot=1, subslot=1, idx=PARAMETER_ACCESS, data=request)
            return read((1, 1), PARAMETER_ACCESS)
        im0 = PNInM0(read((1, 1), IM0))
        check("I&M0: vendor, order code, profile", (im0.vendor_id, text(im0.order_id), im0.im_profile_id),
              (VENDOR, ORDER_ID, ENCODER_API))
        revision = (chr(im0.sw_revision_prefix), im0.im_sw_revision_functional_enhancement, im0.im_sw_revision_bug_fix,
                    im0.im_sw_revision_internal_change)
        check("I&M0: software revision", "{}{}.{}.{}".format(*revision), SOFTWARE)
        check("0xB02E: P964", words(parameter(read_request(1, 964, 6))[6:]), P964)
        check("0xB02E: change of P65000", parameter(change_request(2, 65000, 0x12345)).hex(), "02020101")
        check("0xB02E: P65000 is 0x12345", parameter(read_request(3, 65000)).hex(), "030101014301" + "00012345")
        check("a record that is not there", raw_status(answers, lambda: read((1, 1), 0x7FFF)), "de80b000")
        check("user parameters outside of a start-up", raw_status(answers, lambda: connection.write(
            api=ENCODER_API, slot=1, subslot=1, idx=USER_PARAMETERS, data=START_RECORD)), "df80b500")
    implicit = rpc.RPCCon(device)
    try:
        im0 = implicit.read_implicit(ENCODER_API, 1, 1, IM0).payload
        check("read without a connection: I&M0", text(PNInM0(im0).order_id), ORDER_ID)
    finally:
        implicit.close()


def cyclic(device, own):
    """A session from the connection to its release, with outputs that the encoder answers."""
    setup = IOCRSetup(slots=SLOTS, reduction_ratio=CYCLE_MS, watchdog_factor=WATCHDOG, data_hold_factor=WATCHDOG)
    connection = rpc.RPCCon(device)
    result = connection.connect(own, iocr_setup=setup)
    check("cyclic: frame ids", (result.input_frame_id, 0xC000 <= result.output_frame_id <= 0xF7FF), (0xC001, True))
    alarms = connection.create_alarm_listener(INTERFACE)
    received = []
    alarms.add_callback(received.append)
    alarms.start()
    connection.write(api=ENCODER_API, slot=1, subslot=1, idx=USER_PARAMETERS, data=START_RECORD)
    connection.prm_end()
    ready = connection.application_ready(timeout=10)
    check("cyclic: application ready", (ready[:2].hex(), ready[28:30].hex()), ("0112", "0002"))
    layout = build_iocr_configs(setup.slots, result.input_frame_id, result.output_frame_id, 32, CYCLE_MS, WATCHDOG)
    exchange = CyclicController(INTERFACE, own, s2mac(device.mac), *layout)
    exchange.start()
    exchange.set_output_data(1, 2, (1 << 10).to_bytes(2, "big") + bytes(2))

    def inputs():
        return (exchange.get_input_data(1, 2) or b"")[4:8].hex()
    check("stand: shaft to 70000", stand("shaft counts 70000"), "ok")
    wait_for("cyclic: G1_XIST1 is 70000", inputs, "00011170")
    check("stand: shaft to 0", stand("shaft counts 0"), "ok")
    wait_for("cyclic: G1_XIST1 is 0", inputs, "00000000")
    exchange.set_output_data(1, 2, (1 << 10).to_bytes(2, "big") + (1 << 14).to_bytes(2, "big"))
    wait_for("cyclic: parked on demand", lambda: (exchange.get_input_data(1, 2) or b"\0" * 4)[2] >> 6 & 1, 1)
    check("cyclic: IOPS", exchange.get_input_status(1, 2), 0x80)
    exchange.set_output_data(1, 2, (1 << 10).to_bytes(2, "big") + bytes(2))
    wait_for("cyclic: no longer parked", lambda: (exchange.get_input_data(1, 2) or b"\xff" * 4)[2] >> 6 & 1, 0)

    check("stand: memory fault", stand("fault memory present"), "ok")
    wait_for("alarm: one came", lambda: len(received), 1)
    wait_for("cyclic: goes on", lambda: exchange.stats.frames_received > 60, True)
    exchange.stop()
    alarms.stop()
    check("cyclic: no frame is lost or invalid", (exchange.stats.frames_missed, exchange.stats.frames_invalid), (0, 0))
    connection.close()


def main():
    wire, own = ethernet_socket(INTERFACE, 3), get_mac(INTERFACE)
    find(wire, own)
    device = rpc.get_station_info(wire, own, DEVICE_NAME, strict_xid=True)
    access(device, own)
    time.sleep(0.5)
    cyclic(device, own)
    finish()


main()
