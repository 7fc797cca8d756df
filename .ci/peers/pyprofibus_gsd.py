#!/usr/bin/env python3
"""pyprofibus' parser reads our GSD files, and finds in them what device.yaml says.

    python pyprofibus_gsd.py [SUITES]

Reported in lines `ok ...` or `not ok ...`: the ident number, the names and the configuration bytes of the modules, how many bytes are
exchanged, and the user bytes of Set_Prm as they are before anything changes them.
"""

import pathlib
import sys

import yaml
from pyprofibus.gsd.interp import GsdInterp

import common

# Which variant a file is about; a manual whose variants share a file has one.
FILES = {
    "sick-a3m60-profibus": {"encspec-a3m60.gsd": "a3m60"},
    "datalogic-amt58-profibus": {"encspec-amt58-hs5818.gsd": "hs5818", "encspec-amt58-hm5816-16384.gsd": "hm5816-16384"},
    "dp-slave": {"encspec-plain.gsd": "plain"},
    "dp-encoder": {"encspec-plain-encoder.gsd": "plain"},
}
# The features of the plain slave, all with one module of its GSD.
FEATURES = ["freeze_mode", "sync_mode", "fail_safe", "plain_diagnosis", "address_service", "watchdog_1ms", "ms1", "ms2",
            "identification", "im_class_2", "process_alarm", "diagnosis_alarm", "pull_plug_alarm", "alarm_sequence",
            "alarm_access_point"]
# The features of the plain encoder, by the module that has them.
CLASS_2 = ["class_2", "multiturn", "unscaled", "extended_diagnosis", "encoder_freeze", "encoder_sync"]
# Parameters that such a feature sets, and a module of the GSD does not.
CHOSEN = ["diagnosis_type", "speed_unit"]
# How the modules are called in a GSD.
MODULES = {
    "sick-a3m60-profibus": {"IO_04": "Tel.IO 04", "IO_08": "Tel.IO 08", "telegram_81": "Tel.81", "telegram_83": "Tel.83"},
    "datalogic-amt58-profibus": {"class_1": "Class 1", "class_2": "Class 2", "class_2_vel": "Class 2(+VEL)"},
    "dp-slave": {"data": "Mirror and counter", "mirror": "Mirror and counter", "short": "Mirror",
                 **dict.fromkeys(FEATURES, "Mirror and counter")},
    "dp-encoder": {**dict.fromkeys(["class_1", "class_1_unscaled"], "Class 1"), **dict.fromkeys(CLASS_2, "Class 2"),
                   **dict.fromkeys(["velocity", "velocity_rpm", "velocity_steps"], "Class 2(+VEL)")},
}


def number(device, variant, field, value):
    """A default or a fixed value as a number: itself, a word of the field, or a constant of the variant."""
    if isinstance(value, int):
        return value
    if value.startswith("="):
        constant = device["constants"][value[1:]]
        return constant if isinstance(constant, int) else constant[variant]
    return device["words"][field["words"]][value]


def user_octets(device, variant, fixes):
    """The user bytes of Set_Prm with a module, all else as it is by default."""
    layout = device["set_prm"]
    data = bytearray(layout["octets"])
    for name, field in layout["fields"].items():
        value = number(device, variant, field, fixes.get(name, field["default"]))
        if "bit" in field:
            data[field["octet"]] |= value << field["bit"]
        else:
            first, last = field.get("octets", [field.get("octet")] * 2)
            data[first:last + 1] = value.to_bytes(last + 1 - first, "big")
    return bytes.fromhex(layout["dpv1"]) + bytes(data)


def lengths(configuration):
    """How many bytes go out and come in, by the identifiers as EN 50170 has them."""
    out, into, at = 0, 0, 0
    while at < len(configuration):
        octet = configuration[at]
        count, kind = octet & 15, octet >> 4 & 3
        at += 1
        if kind == 0:
            # Special format: a length octet for outputs, one for inputs, then so many bytes of the maker.
            for bit in (0x80, 0x40):
                if octet & bit:
                    length = configuration[at]
                    size = ((length & 63) + 1) * (2 if length & 0x40 else 1)
                    out, into = (out + size, into) if bit == 0x80 else (out, into + size)
                    at += 1
            at += count
        else:
            size = (count + 1) * (2 if octet & 0x40 else 1)
            out, into = out + size * (kind >> 1), into + size * (kind & 1)
    return {"out": out, "in": into}


def judge(suites, manual, file, variant):
    device = yaml.safe_load((suites / manual / "device.yaml").read_text())
    names = MODULES[manual]
    common.check(f"{file}: modules of device.yaml", list(device["modules"]), list(names))
    gsd = GsdInterp.fromFile(str(suites / manual / file))
    ident = device["identity"]["ident"]
    common.check(f"{file}: ident number", gsd.getIdentNumber(), ident if isinstance(ident, int) else ident["value"])
    described = list(dict.fromkeys(names.values()))
    common.check(f"{file}: names of the modules", [module.name for module in gsd.getField("Module")], described)
    common.check(f"{file}: it has one module of several", (gsd.isModular(), gsd.getField("Max_Module")), (True, 1))
    common.check(f"{file}: bytes of diagnosis", gsd.getField("Max_Diag_Data_Len"), max(device["diagnosis"]["octets"]))
    for name, module in device["modules"].items():
        gsd.clearConfiguredModules()
        gsd.setConfiguredModule(names[name])
        configuration = b"".join(bytes(element.getDU()) for element in gsd.getCfgDataElements())
        common.check(f"{file}: configuration of {name}", configuration.hex(" "), bytes.fromhex(module["cfg"]).hex(" "))
        common.check(f"{file}: lengths of {name}", lengths(configuration), module["octets"])
        common.check(f"{file}: user bytes with {name}", bytes(gsd.getUserPrmData()).hex(" "),
                     user_octets(device, variant, {key: value for key, value in module.get("fixes", {}).items()
                                                   if key not in CHOSEN}).hex(" "))


def main():
    here = pathlib.Path(__file__).resolve().parent.parent.parent
    suites = pathlib.Path(sys.argv[1]) if sys.argv[1:] else here / "suites"
    found = sorted(path.relative_to(suites).as_posix() for path in suites.glob("*/*.gsd"))
    common.check("all GSD files are known", found, sorted(f"{manual}/{file}" for manual, files in FILES.items() for file in files))
    for manual, files in FILES.items():
        for file, variant in files.items():
            judge(suites, manual, file, variant)
    common.finish()


main()
