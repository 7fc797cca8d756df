#!/usr/bin/env python3
"""An absolute encoder without a network stack, to be tested by encspec over standard input and output.

On PROFINET it is an encoder of the encoder profile with telegram 81, on PROFIBUS one of class 2. Only the standard library is used.
The protocol is described in docs/application-protocol.md. `--mistake NAME` makes it deviate on purpose.
"""

import json
import math
import sys

STEPS, REVOLUTIONS = 8192, 4096  # of the hardware: per revolution, and revolutions
TOTAL = STEPS * REVOLUTIONS
SECOND = 1_000_000_000  # in nanoseconds
FOREVER = 1 << 53
MAP, TELEGRAM = 1, 2  # subslots of slot 1: parameter access point, and the telegram
START_RECORD, PARAMETERS = 0xBF00, 0xB02E  # records
CODE_SEQUENCE, CLASS_4, PRESET_NOT_XIST1, SCALING, ALARMS, NOT_COMPATIBLE = 1, 2, 4, 8, 16, 32  # bits of the start parameters
START_LENGTH = 31  # flags, units per revolution and range of 8 bytes, tolerated failures, unit of the velocity, reserved
SENSOR_ERROR, PARKING_ERROR, LIFE_SIGN_ERROR = 0x0001, 0x0003, 0x0F02  # codes in G1_XIST2
FAULTS = {"fault.sensor": 0x0009, "fault.passing": 0x0005, "fault.standing": 0x0006}  # with their ChannelErrorType
MISTAKES = ("diagnosis", "record", "configuration", "direction", "preset", "sequence")

SUBMODULES = [
    {"slot": 0, "module_ident": 1, "subslot": 1, "submodule_ident": 1},
    {"slot": 1, "module_ident": 0x51, "subslot": MAP, "submodule_ident": 2, "api": 0x3D00},
    {"slot": 1, "module_ident": 0x51, "subslot": TELEGRAM, "submodule_ident": 81, "api": 0x3D00, "inputs": 12, "outputs": 4},
]
DESCRIPTION = {
    "version": 1,
    "name": "example encoder in Python",
    "stand": ["shaft.speed", "shaft.counts", "turn", "fault.sensor", "fault.passing", "fault.standing"],
    "profinet": {
        "vendor_id": 0xFEED,
        "device_id": 0x00E0,
        "station_type": "EXAMPLE ENCODER",
        "order_id": "EXAMPLE-81",
        "serial_number": "0001",
        "profile_id": 0x3D00,
        "im_supported": 0b1110,
        "ports": 2,
        "submodules": SUBMODULES,
    },
    "profibus": {"ident": 0xFEED, "configuration": "D1E1", "dpv1": True, "fail_safe": True, "freeze": True, "sync": True,
                 "set_address": True},
}


class Shaft:
    """The shaft, in hardware steps without a limit: it turns steadily, or until it has reached a target."""

    def __init__(self, counts):
        self.begin, self.start, self.rate, self.end, self.target = 0, counts, 0.0, FOREVER, counts

    def at(self, now):
        if now >= self.end:
            return self.target
        return self.start + math.floor(self.rate * (now - self.begin) / SECOND)

    def is_still(self, now):
        return self.rate == 0 or now >= self.end

    def speed(self, now, rpm):
        self.start, self.begin, self.rate, self.end = self.at(now), now, rpm * STEPS / 60, FOREVER

    def turn(self, now, steps, rpm):
        """Turns by a distance, and returns when it is done."""
        self.speed(now, math.copysign(rpm, steps))
        self.target, self.end = self.start + round(steps), now + math.ceil(abs(steps / self.rate) * SECOND)
        return self.end


class Refused(Exception):
    """A record access that is refused, with a word of the protocol."""


class Encoder:
    """What both buses share: settings, position and preset."""

    def __init__(self, mistake):
        self.mistake = mistake
        self.reset(0)

    def reset(self, counts):
        self.shaft = Shaft(counts)
        self.offset, self.saved_offset, self.preset_value, self.saved_preset = 0, 0, 0, 0
        self.faults = set()
        self.diagnosis, self.diagnosis_changed = [], False
        self.start_up()

    def start_up(self):
        """Everything that is lost with the supply."""
        self.flags, self.units, self.range = CLASS_4 | SCALING | NOT_COMPATIBLE, STEPS, TOTAL
        self.offset, self.preset_value = self.saved_offset, self.saved_preset
        self.responses = {}
        self.tolerated, self.speed_unit = 1, 0
        self.begin_connection()

    def begin_connection(self):
        self.stw2 = self.g1_stw = self.g1_zsw = self.sign = self.last_sign = self.account = 0
        self.watches = self.acknowledging = self.parked = False
        self.errors = [SENSOR_ERROR] if self.has_sensor_fault() else []

    def raw(self, now):
        is_reversed = self.flags & CODE_SEQUENCE and self.flags & CLASS_4 and self.mistake != "direction"
        return -self.shaft.at(now) if is_reversed else self.shaft.at(now)

    def measured(self, now):
        if self.flags & CLASS_4 and self.flags & SCALING:
            return self.raw(now) * self.units // STEPS % self.range
        return self.raw(now) % TOTAL

    def span(self):
        return self.range if self.flags & CLASS_4 and self.flags & SCALING else TOTAL

    def position(self, now):
        return (self.measured(now) + (self.offset if self.flags & CLASS_4 else 0)) % self.span()

    def preset(self, now, value, relative=False):
        if self.mistake == "preset":
            value += 1
        offset = self.offset + value if relative else value - self.measured(now)
        self.offset = self.saved_offset = offset % self.span()

    def act(self, now, name, value, unit=None, rpm=0.0):
        if name == "shaft.speed":
            self.shaft.speed(now, value)
        elif name == "shaft.counts":
            self.shaft = Shaft(value)
        elif name == "turn":
            return self.shaft.turn(now, value * (STEPS if unit == "revolutions" else 1), rpm)
        elif name in FAULTS:
            self.fault(name, value)
        else:
            return None
        return now

    def has_sensor_fault(self):
        return "fault.sensor" in self.faults

    def fault(self, name, present):
        if present == (name in self.faults) or (not present and self.mistake == "diagnosis"):
            return
        self.faults ^= {name}
        if name == "fault.sensor" and present and not self.parked:
            self.raise_error(SENSOR_ERROR)
        if name != "fault.sensor" or self.flags & ALARMS:
            self.report(name, present)

    def report(self, name, present):
        self.diagnosis.append({"appears": present, "slot": 1, "subslot": MAP, "error_type": FAULTS[name]})
        self.diagnosis_changed = True

    # Signals of telegram 81.

    def outputs(self, now, data):
        if data is None:
            stw2, g1_stw = 0, 0
        else:
            stw2, g1_stw = int(data[:4], 16), int(data[4:8], 16)
            self.watch(stw2 >> 12)
        if self.flags & NOT_COMPATIBLE and not stw2 & 0x0400:  # without control by PLC no request is valid
            g1_stw = 0
        new = g1_stw & ~self.g1_stw
        if not g1_stw & 0x4000:
            # With the mistake it stays parked while an acknowledgement is requested.
            self.parked = self.parked and self.mistake == "sequence" and bool(g1_stw & 0x8000)
        elif new & 0x4000 and self.shaft.is_still(now):
            self.parked, self.acknowledging, self.g1_zsw, self.errors = True, False, 0, []
        elif new & 0x4000:
            self.raise_error(PARKING_ERROR)
        if new & 0x1000 and not self.parked and self.flags & CLASS_4:
            self.preset(now, self.preset_value, bool(g1_stw & 0x0800))
            self.g1_zsw |= 0x1000
        if not g1_stw & 0x1000:
            self.g1_zsw &= ~0x1000
        if new & 0x8000 and self.errors and not self.parked:
            self.acknowledging = True
        elif not g1_stw & 0x8000 and self.acknowledging:
            self.acknowledging = False
            self.errors = [SENSOR_ERROR] if self.has_sensor_fault() else []
        self.stw2, self.g1_stw = stw2, g1_stw

    def watch(self, sign):
        """The sign of life of the controller: a failure weighs ten times as much as a good one."""
        last, self.last_sign = self.last_sign, sign
        if not self.watches:
            self.watches = sign != 0
            return
        limit = 10 * (1 if self.flags & NOT_COMPATIBLE else self.tolerated)
        is_next = sign == last % 15 + 1
        self.account = max(self.account - 1, 0) if is_next else min(self.account + 10, limit + 1)
        if self.account > limit and not self.parked:
            self.raise_error(LIFE_SIGN_ERROR)

    def raise_error(self, code):
        if code not in self.errors:
            self.errors.append(code)

    def inputs(self, now):
        self.sign = self.sign % 15 + 1
        zsw2 = self.sign << 12 | (0x0200 if self.flags & NOT_COMPATIBLE and self.stw2 & 0x0400 else 0)
        position = 0 if self.parked else self.position(now)
        g1_zsw = self.g1_zsw | (0x0800 if self.acknowledging else 0) | (0x4000 if self.parked else 0)
        xist1 = self.measured(now) if self.flags & PRESET_NOT_XIST1 and not self.parked else position
        if self.errors:
            g1_zsw, xist2 = g1_zsw | 0x8000, self.errors[0]
        elif self.g1_stw & 0x2000 and not self.parked:
            g1_zsw, xist2 = g1_zsw | 0x2000, position
        else:
            xist2 = 0
        return f"{zsw2:04X}{g1_zsw:04X}{xist1:08X}{xist2:08X}"

    # Records: start parameters, and base mode parameter access.

    def apply(self, flags, units, span):
        is_scaled = flags & CLASS_4 and flags & SCALING
        if is_scaled and not (1 <= units <= STEPS and 2 <= span <= units * REVOLUTIONS):
            return False
        self.flags, self.units, self.range = flags, units, span
        return True

    def write_record(self, now, place, connection, data):
        if place == (1, MAP, START_RECORD):
            if len(data) != START_LENGTH:
                raise Refused("write_length_error")
            is_valid = data[17] >= 1 and data[18] <= 3
            if not is_valid or not self.apply(data[0], int.from_bytes(data[1:9], "big"), int.from_bytes(data[9:17], "big")):
                raise Refused("invalid_parameter")
            self.tolerated, self.speed_unit = data[17], data[18]
        elif place == (1, MAP, PARAMETERS):
            if len(data) < 4 or not 1 <= data[3] <= 39 or len(data) < 4 + 6 * data[3]:
                raise Refused("write_length_error")
            self.responses[connection] = self.respond(now, data)
        else:
            raise Refused("invalid_index")

    def read_record(self, place, connection):
        if place == (1, MAP, START_RECORD):
            head = bytes([self.flags]) + self.units.to_bytes(8, "big") + self.range.to_bytes(8, "big")
            return (head + bytes([self.tolerated, self.speed_unit])).ljust(START_LENGTH, b"\0")
        if place != (1, MAP, PARAMETERS):
            if self.mistake == "record":
                return b"\0"
            raise Refused("invalid_index")
        if connection not in self.responses:
            raise Refused("state_conflict")
        return self.responses.pop(connection)

    def parameter(self, number, now):
        """Format and values of a parameter, and whether it has subindices and can be written."""
        words, long_words, octets = 0x42, 0x43, 0x0A
        table = {
            922: (words, [81], False, False),
            925: (words, [self.tolerated], False, True),
            964: (words, [0xFEED, 1, 100, 2026, 2811, 1], True, False),
            965: (octets, [0x3D, 41 if self.flags & NOT_COMPATIBLE else 31], False, False),
            971: (words, [0], False, True),
            974: (words, [240, 39, 0], True, False),
            975: (words, [0xFEED, 1, 100, 2026, 2811, 0x0005, 0x8000, 1], True, False),
            979: (long_words, [0x5011, 0x80000000, STEPS, 0, 0, REVOLUTIONS], True, False),
            980: (words, [922, 925, 964, 965, 971, 974, 975, 979, 65000, 65001, 0], True, False),
            65000: (long_words, [self.preset_value], False, True),
            65001: (long_words, [0x000C0101, self.flags, 1 if self.has_sensor_fault() else 0, 0x0031, 0, 0, 0x01010000, 0xFFFFFFFF,
                                 self.offset, self.units, self.range, self.speed_unit], True, False),
        }
        return table.get(number)

    def respond(self, now, data):
        reference, kind, axis, count = data[:4]
        at, has_error, body = 4 + 6 * count, False, b""
        for index in range(count):
            attribute, elements, number, subindex = (
                data[4 + 6 * index], data[5 + 6 * index],
                int.from_bytes(data[6 + 6 * index:8 + 6 * index], "big"), int.from_bytes(data[8 + 6 * index:10 + 6 * index], "big"))
            value = None
            if kind == 2 and at + 2 <= len(data):
                size = {0x41: 1, 0x42: 2, 0x43: 4, 5: 1, 6: 2, 7: 4, 2: 1, 3: 2, 4: 4, 0x0A: 1}.get(data[at], 0)
                end = at + 2 + data[at + 1] * size
                value = (data[at], size, data[at + 1], data[at + 2:end])
                at = end + (end - at) % 2
            error, where, part = self.access(now, kind, axis, attribute, elements, number, subindex, value)
            if error is None and len(body) + len(part) > 236 - 6 * (count - index - 1):
                error = 0x15  # the response would be too long
            if error is None:
                body += part
            else:
                has_error = True
                body += bytes([0x44, 1 if where is None else 2]) + error.to_bytes(2, "big")
                body += b"" if where is None else where.to_bytes(2, "big")
        if kind == 2 and not has_error:
            body = b""
        return bytes([reference, (kind if kind in (1, 2) else 1) | (0x80 if has_error else 0), axis, count]) + body

    def access(self, now, kind, axis, attribute, elements, number, subindex, value):
        """One parameter of a request: error number, subindex of the error, or its part of the response."""
        if kind not in (1, 2):
            return 0x21, None, b""
        if axis > 1:
            return 0x19, None, b""
        known = self.parameter(number, now)
        if known is None:
            return 0x00, None, b""
        form, values, is_array, is_writable = known
        if attribute != 0x10:
            return 0x16, None, b""
        if kind == 2 and not is_writable:
            return 0x01, None, b""
        if not is_array and (subindex or elements > 1):
            return 0x04, None, b""
        count = len(values) if form == 0x0A else max(elements, 1)
        if subindex + count > len(values):
            return 0x03, max(subindex, len(values)), b""
        width = {0x42: 2, 0x43: 4, 0x0A: 1}[form]
        if kind == 1:
            part = b"".join(number.to_bytes(width, "big") for number in values[subindex:subindex + count])
            return None, None, bytes([form, count]) + part + b"\0" * (len(part) % 2)
        if value is None or value[1] == 0:
            return 0x17, None, b""
        if value[2] != 1:
            return 0x18, None, b""
        if value[1] != width:
            return 0x05, None, b""
        return self.write(number, int.from_bytes(value[3], "big")), None, bytes([0x40, 0])

    def write(self, number, value):
        if number == 925:
            if not 1 <= value <= 255:
                return 0x02
            self.tolerated = value
        elif number == 971:
            if value > 1:
                return 0x02
            self.saved_offset, self.saved_preset = self.offset, self.preset_value
        elif value >= self.span():
            return 0x02
        else:
            self.preset_value = value
        return None

    # PROFIBUS, class 2.

    def set_prm(self, data):
        if len(data) != 14:  # three bytes of DP-V1, flags, units per revolution, range, reserved
            return False
        return self.apply(data[3], int.from_bytes(data[4:8], "big"), int.from_bytes(data[8:12], "big"))

    def dp_outputs(self, now, data):
        word = 0 if data is None else int(data, 16)
        if word >> 31 and not self.stw2:
            self.preset(now, (word & 0x7FFFFFFF) % self.span())
            self.saved_offset = self.offset
        self.stw2 = word >> 31

    def dp_diagnosis(self):
        def word(value, octets):
            return value.to_bytes(octets, "big")
        alarm = 1 if self.faults else 0
        return (bytes([0x33, alarm, self.flags & 0x0F, 1]) + word(STEPS, 4) + word(REVOLUTIONS, 2) + b"\0" + word(1, 2) + word(0, 2)
                + word(0, 2) + word(0x0110, 2) + word(0x0100, 2) + word(0xFFFFFFFF, 4) + word(self.offset, 4) + word(0, 4)
                + word(self.units, 4) + word(self.range, 4) + b"0000000001"), bool(alarm)


def answer(encoder, message):
    """The fields of an answer, beside the word of the message."""
    word, now = message["message"], message.get("now", 0)
    if word == "cycle":
        for outputs in message.get("outputs", ()):
            encoder.outputs(outputs["at"], outputs["data"])
        if message["inputs"]:
            return {"inputs": [{"slot": 1, "subslot": TELEGRAM, "data": encoder.inputs(now), "good": not encoder.has_sensor_fault()}]}
    elif word == "data_exchange":
        if "outputs" in message:
            encoder.dp_outputs(now, message["outputs"])
        if message["inputs"]:
            still = FOREVER if encoder.shaft.is_still(now) else 0
            return {"data": f"{encoder.position(now):08X}", "constant_until": still}
    elif word == "hello":
        return {"description": DESCRIPTION}
    elif word == "reset":
        encoder.reset(message["shaft"])
    elif word == "power_up":
        encoder.start_up()
        for name in sorted(encoder.faults):
            encoder.report(name, True)
    elif word in ("connect", "exchange_begins"):
        encoder.begin_connection()
    elif word == "disconnect":
        encoder.responses.pop(message["connection"], None)
    elif word in ("read_record", "write_record"):
        place = (message["slot"], message.get("subslot", 0), message["index"])
        try:
            if word == "read_record":
                return {"data": encoder.read_record(place, message["connection"]).hex()}
            encoder.write_record(now, place, message["connection"], bytes.fromhex(message["data"]))
        except Refused as refused:
            return {"refused": str(refused)}
    elif word == "factory_reset":
        if message["scope"] in ("engineering", "factory_image", "other"):
            return {}
        if message["scope"] != "communication":
            encoder.saved_offset = encoder.saved_preset = encoder.offset = encoder.preset_value = 0
        return {"done": now}
    elif word == "set_prm":
        return {"accepted": encoder.set_prm(bytes.fromhex(message["data"]))}
    elif word == "chk_cfg":
        is_right = message["data"] == "D1E1" or encoder.mistake == "configuration"
        return {"accepted": is_right, "input_length": 4, "output_length": 4}
    elif word == "diagnosis":
        blocks, ext_diag = encoder.dp_diagnosis()
        return {"data": blocks.hex(), "ext_diag": ext_diag}
    elif word == "act":
        done = encoder.act(now, message["name"], message["value"], message.get("unit"), message.get("rpm", 0.0))
        return {} if done is None else {"done": done}
    return {}


def main():
    mistake = None
    if sys.argv[1:2] == ["--mistake"]:
        mistake = sys.argv[2]
        if mistake not in MISTAKES:
            sys.exit(f"unknown mistake {mistake}; there are {', '.join(MISTAKES)}")
    encoder, bus = Encoder(mistake), None
    read, write = sys.stdin.readline, sys.stdout.write
    while line := read():
        message = json.loads(line)
        bus = message.get("bus", bus)
        fields = {"answer": message["message"], **answer(encoder, message)}
        if bus == "profinet" and encoder.diagnosis:
            fields["diagnosis"] = encoder.diagnosis
        elif bus == "profibus" and encoder.diagnosis_changed:
            fields["diagnosis_changed"] = True
        encoder.diagnosis, encoder.diagnosis_changed = [], False
        write(json.dumps(fields) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
