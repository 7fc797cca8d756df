#!/usr/bin/env python3
"""pyprofibus, a PROFIBUS DP-V0 master, at the served slaves of both manuals and at the plain slave.

    python pyprofibus_master.py CONTROL TTY SESSION

It takes parameters and configuration from our GSD files, and each of its checks is reported in a line. Expected is what the manuals
print: their dumps, their preset tables, their worked scaling. pyprofibus sends neither tokens nor Global_Control.
"""

import pathlib
import sys
import time
import types

from pyprofibus.dp import DpTelegram, DpTelegram_SlaveDiag_Con
from pyprofibus.dp_master import DPM1, DpSlaveDesc, DpSlaveState
from pyprofibus.fdl import FdlError, FdlTelegram
from pyprofibus.gsd.interp import GsdInterp
from pyprofibus.phy_serial import CpPhySerial

import common

SUITES = pathlib.Path(__file__).resolve().parent.parent.parent / "suites"
A3M60, AMT58 = SUITES / "sick-a3m60-profibus", SUITES / "datalogic-amt58-profibus"
# The manual of the AMT58 shows a master at 2. At this baud rate pyprofibus waits long enough for a busy machine.
MASTER, SLAVE, BAUD = 2, 3, 19_200
DIAGNOSIS = DpTelegram.DSAP_SLAVE_DIAG
# A host that stalls for a moment is no reason to begin again.
PATIENT = {state: 5.0 for state, limit in DpSlaveState.stateTimeLimits.items() if limit > 0}


class Ear(CpPhySerial):
    """The line of pyprofibus, which keeps the whole diagnosis of the slave: pyprofibus itself drops all after six bytes."""

    __slots__ = ("diagnosis", "diagnoses")

    def __init__(self, tty):
        super().__init__(port=tty)
        self.diagnosis, self.diagnoses = None, 0
        self.setConfig(baudrate=BAUD)

    def pollData(self, timeout=0.0):
        frame = super().pollData(timeout)
        if frame:
            try:
                telegram = FdlTelegram.fromRawData(frame)
            except FdlError:
                return frame
            if telegram.sae and DpTelegram.extractSAP(telegram.sae) == DIAGNOSIS:
                self.diagnosis, self.diagnoses = telegram, self.diagnoses + 1
        return frame


class Master:
    """A master with one slave, as one module of a GSD file has it; `octets` stands in for the user octets of the GSD."""

    def __init__(self, tty, gsd, module, lengths, octets=None, watchdog=10_000):
        self.phy = Ear(tty)
        self.gsd = GsdInterp.fromFile(str(gsd))
        self.gsd.clearConfiguredModules()
        self.gsd.setConfiguredModule(module)
        out, into = lengths
        self.slave = DpSlaveDesc(types.SimpleNamespace(gsd=self.gsd, addr=SLAVE, name="encoder", index=0, inputSize=out,
                                                       outputSize=into, diagPeriod=0))
        self.slave.setCfgDataElements(self.gsd.getCfgDataElements())
        self.slave.setUserPrmData(octets if octets is not None else self.gsd.getUserPrmData())
        self.slave.setWatchdog(watchdog)
        self.dpm = DPM1(self.phy, masterAddr=MASTER)
        self.dpm.addSlave(self.slave)
        self.dpm.initialize()

    def cycle(self, outputs, seconds=20.0):
        """One exchange of data, after the start-up where there was none: the inputs that answer these outputs."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.slave.setMasterOutData(bytearray(outputs))
            self.dpm.run()
            inputs = self.slave.getMasterInData()
            if inputs is not None:
                self.slave.setMasterOutData(None)
                return bytes(inputs).hex(" ")
        return "none"

    def settle(self, outputs, expected, seconds=5.0):
        """Exchanges data until the inputs are as expected; gives the last inputs."""
        end = time.monotonic() + seconds
        while (observed := self.cycle(outputs)) != expected and time.monotonic() < end:
            time.sleep(0.02)
        return observed

    def diagnose(self, outputs, seconds=20.0):
        """Makes pyprofibus read the diagnosis amid the data exchange: all its octets."""
        before, end = self.phy.diagnoses, time.monotonic() + seconds
        self.slave.diagPeriod = 1
        while self.phy.diagnoses == before and time.monotonic() < end:
            self.slave.setMasterOutData(bytearray(outputs))
            self.dpm.run()
        self.slave.diagPeriod = 0
        return "none" if self.phy.diagnoses == before else bytes(self.phy.diagnosis.du).hex(" ")

    def end(self):
        self.dpm.destroy()


def power_on(master, ident):
    """What pyprofibus makes of the first diagnosis: it requires parameters, no master has them, the ident number is that of the GSD."""
    end = time.monotonic() + 20
    while not master.phy.diagnoses and time.monotonic() < end:
        master.dpm.run()
    diagnosis = master.phy.diagnosis and DpTelegram_SlaveDiag_Con.fromFdlTelegram(master.phy.diagnosis)
    common.check("the slave reports its diagnosis", diagnosis is not None, True)
    if diagnosis:
        common.check("first diagnosis: not ready, parameters required, no fault", (diagnosis.notReady(), diagnosis.prmReq(), diagnosis.hasOnebit(),
                     diagnosis.cfgFault(), diagnosis.prmFault(), diagnosis.isNotSupp(), diagnosis.masterLock()), (True, True, True) + (False,) * 4)
        common.check("first diagnosis: master and ident number", (diagnosis.masterAddr, diagnosis.identNumber), (255, ident))
        common.check("the ident number of the GSD", master.gsd.getIdentNumber(), ident)


def amt58_preset(tty):
    """Sections 6.4.3 and 6.6 of the manual: the shaft stands at 5 5000h of 2^30."""
    gsd = AMT58 / "encspec-amt58-hm5816-16384.gsd"
    # 2048 steps in each of 1024 turns, octet by octet as the manual has it: 5 5000h is 5.3125 turns.
    scaled = Master(tty, gsd, "Class 2", (4, 4), bytes.fromhex("000000 0A 00000800 00200000 0000"))
    power_on(scaled, 0x1655)
    common.check("2048 steps in 1024 turns: the position", scaled.cycle(bytes(4)), "00 00 2a 80")
    scaled.end()
    master = Master(tty, gsd, "Class 2", (4, 4))
    common.check("the position", master.cycle(bytes(4)), "00 05 50 00")
    common.check("reduced diagnosis", master.diagnose(bytes(4)), "00 0c 00 02 16 55 0a 00 0a 01 00 01 00 00 40 00")
    common.check("a value without bit 31 does nothing", [master.cycle(bytes.fromhex("00001000")) for _ in range(5)], ["00 05 50 00"] * 5)
    preset = bytes.fromhex("80001000")
    common.check("two cycles with bit 31 do nothing", [master.cycle(preset) for _ in range(2)], ["00 05 50 00"] * 2)
    common.check("bit 31 goes before the third", [master.cycle(bytes(4)) for _ in range(3)], ["00 05 50 00"] * 3)
    common.check("the table of the preset", [master.cycle(preset) for _ in range(3)], ["00 05 50 00", "00 05 50 00", "00 00 10 00"])
    common.check("after the preset", [master.cycle(bytes(4)) for _ in range(5)], ["00 00 10 00"] * 5)
    common.check("the shaft turns on by 123h", common.stand(f"shaft counts {0x55123}"), "ok")
    common.check("the position follows", master.settle(bytes(4), "00 00 11 23"), "00 00 11 23")
    # Section 6.4.3 forbids it: 8192 steps in a revolution and 360 in all.
    master.end()
    master = Master(tty, gsd, "Class 2", (4, 4), bytes.fromhex("000000 0A 00002000 00000168 0000"))
    # The slave has no service for Chk_Cfg then, and pyprofibus reads the diagnosis once it has given that up.
    end, exchanged = time.monotonic() + 20, set()
    while master.phy.diagnoses < 2 and time.monotonic() < end:
        exchanged.add(master.cycle(bytes(4), seconds=0.2))
    common.check("a range below one turn is no data exchange", exchanged, {"none"})
    diagnosis = DpTelegram_SlaveDiag_Con.fromFdlTelegram(master.phy.diagnosis)
    common.check("it is a parameter fault, and no other", (diagnosis.prmFault(), diagnosis.cfgFault()), (True, False))
    master.end()


def amt58_diagnosis(tty):
    """Sections 5.1.3 and 5.2: the screen of Class 2(+VEL) of the HS58, and the head of the dump that it leads to."""
    gsd = AMT58 / "encspec-amt58-hs5818.gsd"
    master = Master(tty, gsd, "Class 2(+VEL)", (4, 8), bytes.fromhex("000000 CA 00040000 00040000 01 00"))
    power_on(master, 0x1655)
    common.check("position and velocity at rest", master.cycle(bytes(4)), "00 00 10 01 00 00 00 00")
    dump = master.diagnose(bytes(4))
    common.check("the dump: its length", len(bytes.fromhex(dump)), 63)
    common.check("the dump: its first ten octets", dump[:29], "00 0c 00 02 16 55 39 00 ca 00")
    common.check("the dump: programmed steps and range", dump[39 * 3:47 * 3 - 1], "00 04 00 00 00 04 00 00")
    common.check("60 revolutions in a minute", common.stand("shaft speed 60"), "ok")
    end, steps = time.monotonic() + 5, 0
    while abs(steps - 262_144) > 2_621 and time.monotonic() < end:
        steps = int.from_bytes(bytes.fromhex(master.cycle(bytes(4)))[4:], "big", signed=True)
    common.check("are 262144 steps in a second", abs(steps - 262_144) <= 2_621 or steps, True)
    master.end()
    other = Master(tty, gsd, "Class 1", (4, 4))
    common.check("another class is configured", len(bytes.fromhex(other.cycle(bytes(4)))), 4)
    common.check("Class 1 has the reduced diagnosis", len(bytes.fromhex(other.diagnose(bytes(4)))), 16)
    other.end()


def a3m60(tty):
    """Table 8 and figures 9 to 11 of the manual: the shaft stands at AAh; then tables 33 to 35."""
    gsd = A3M60 / "encspec-a3m60.gsd"
    master = Master(tty, gsd, "Tel.IO 04", (4, 4))
    power_on(master, 0x0C0A)
    held, edge = bytes.fromhex("0000FFFF"), bytes.fromhex("8000FFFF")
    common.check("table 8, step 1", [master.cycle(held) for _ in range(3)], ["00 00 00 aa"] * 3)
    common.check("table 8, steps 2 and 3", (master.cycle(edge), master.settle(held, "00 00 ff ff"))[1], "00 00 ff ff")
    common.check("figures 9 and 10", master.settle(bytes.fromhex("00000010"), "00 00 ff ff"), "00 00 ff ff")
    common.check("figure 11", master.settle(bytes.fromhex("80000010"), "00 00 00 10"), "00 00 00 10")
    common.check("the shaft turns on by one step", common.stand(f"shaft counts {0xAB}"), "ok")
    held = bytes.fromhex("80000010")
    common.check("bit 31 that stays is no edge", master.settle(held, "00 00 00 11"), "00 00 00 11")
    common.check("diagnosis without errors", master.diagnose(held), "00 0c 00 02 0c 0a")
    common.check("the parameters are invalid", common.stand("fault flash present"), "ok")
    common.check("table 35: -12", master.settle(held, "ff ff ff f4"), "ff ff ff f4")
    common.check("the alarm channel is off: six octets", len(bytes.fromhex(master.diagnose(held))), 6)
    common.check("the parameters are right again", common.stand("fault flash absent"), "ok")
    common.check("the position is back", master.settle(held, "00 00 00 11"), "00 00 00 11")
    # With the alarm channel on: bit 4 of the first of our octets.
    octets = bytearray(master.gsd.getUserPrmData())
    master.end()
    octets[3] |= 0x10
    master = Master(tty, gsd, "Tel.IO 08", (8, 8), octets)
    common.check("IO 08: position and speed at rest", master.cycle(bytes(8))[:17], "00 00 00 11 00 00")
    before = master.phy.diagnoses
    common.check("the parameters are invalid", common.stand("fault flash present"), "ok")
    await_diagnosis(master, bytes(8), before)
    common.check("tables 33 and 34: memory error", bytes(master.phy.diagnosis.du)[6:].hex(" "), "81 40 38")
    diagnosis = DpTelegram_SlaveDiag_Con.fromFdlTelegram(master.phy.diagnosis)
    common.check("an error is extended diagnosis", (diagnosis.hasExtDiag(), diagnosis.isReadyDataEx()), (True, True))
    common.check("table 35: -12", master.cycle(bytes(8))[:11], "ff ff ff f4")
    master.end()


def await_diagnosis(master, outputs, before):
    """Exchanges data until pyprofibus has read more diagnoses than `before`."""
    end = time.monotonic() + 10
    while master.phy.diagnoses == before and time.monotonic() < end:
        master.cycle(outputs)
    common.check("a high-priority answer has pyprofibus read the diagnosis", master.phy.diagnoses > before, True)


def plain(tty):
    """The slave that sends back what it gets, and reports a short circuit in blocks of all three kinds (EN 50170, Slave_Diag)."""
    master = Master(tty, SUITES / "dp-slave" / "encspec-plain.gsd", "Mirror", (4, 4))
    power_on(master, 0xFEED)
    for outputs in ("01 02 03 04", "ff ff ff ff", "00 00 00 00"):
        common.check(f"{outputs} comes back", master.settle(bytes.fromhex(outputs), outputs), outputs)
    common.check("diagnosis without a fault", master.diagnose(bytes(4)), "00 0c 00 02 fe ed")
    before = master.phy.diagnoses
    common.check("a short circuit", common.stand("fault passing present"), "ok")
    await_diagnosis(master, bytes(4), before)
    common.check("status, module and channel", bytes(master.phy.diagnosis.du)[6:].hex(" "), "05 81 00 00 01 42 01 80 c0 81")
    master.end()


SESSIONS = {"plain": plain, "amt58-preset": amt58_preset, "amt58-diagnosis": amt58_diagnosis, "a3m60": a3m60}


def main():
    _, _, tty, session = sys.argv
    DpSlaveState.stateTimeLimits = DpSlaveState.stateTimeLimits | PATIENT
    SESSIONS[session](tty)
    common.finish()


main()
