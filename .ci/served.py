"""Served reference devices: on veth pairs in a network namespace of their own, on sockets and on pseudoterminals."""
import collections
import concurrent.futures
import contextlib
import itertools
import json
import os
import pathlib
import re
import subprocess
import sys
import time

import day

BINARY, SCRATCH = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve() / pathlib.Path(sys.argv[0]).name
BENCH = """\
device: {manual}/{variant}
link: {link}
station_name: encoder-under-test
ip: 192.168.0.10
watchdog: 80ms
ip_permanence: permanent
direct_cable: true
gsdml: {gsdml}
stand: {{ control: {control}, shaft: [position(±0), speed(±0)] }}
consent: {{ set_name: true, set_ip: true, im_records: true, nvm_write: 10000, position_reference: true, factory_reset: true, firmware: true, overstress: true, alone: true }}
{pages}
"""
SLAVE = """\
device: {manual}/{variant}
link: {link}
gsd: {gsd}
stand: {{ control: {control}, shaft: [position(±0), speed(±0)] }}
consent: {{ set_address: true, lock_address: true, set_name: true, im_records: true, nvm_write: 10000, position_reference: true, factory_reset: true, overstress: true, alone: true }}
"""
# The web pages of a reference device are where device.yaml says.
PAGES = {"lika-xac77-profinet": "pages: { home: {}, information: {}, parameters: {}, position: {}, preset: {}, upgrade: {} }"}

Device = collections.namedtuple("Device", "manual variant kind")
Device.__str__ = lambda device: f"{device.manual}/{device.variant} on {device.kind}"


def in_a_namespace():
    """Starts this script again where no other process sees its interfaces."""
    if os.environ.get("ENCSPEC_LIVE_INSIDE"):
        return
    how = ["unshare", "-n"] if os.geteuid() == 0 else ["unshare", "-rn"]
    os.execvpe(how[0], [*how, sys.executable, *sys.argv], {**os.environ, "ENCSPEC_LIVE_INSIDE": "1"})


def ip(*words):
    subprocess.run(["ip", *words], check=True)


SUITES = pathlib.Path(__file__).resolve().parent.parent / "suites"


def description_of(manual, variant, files):
    """The description that we ship for a reference device."""
    files = sorted((SUITES / manual).glob(files))
    fitting = [file for file in files if variant.lower() in file.name.lower()]
    return (fitting or files)[0]


class Served:
    """A served device with the link to it and its bench file."""

    numbers = itertools.count()

    def __init__(self, device, deviations=(), bench=""):
        """`deviations` are words like `--bug NAME`, `bench` is a further line of the bench file."""
        manual, variant, kind = device
        number = next(Served.numbers)
        self.folder = SCRATCH / f"{number}"
        self.folder.mkdir()
        control = self.folder / "control"
        self.interface = None
        if kind == "nic":
            self.interface = f"h{number}"
            ip("link", "add", f"h{number}", "type", "veth", "peer", "name", f"d{number}")
            ip("link", "set", f"h{number}", "up")
            ip("link", "set", f"d{number}", "up")
            ours, link = ["--nic", f"d{number}"], f"nic:h{number}"
        elif kind == "pty":
            address = re.search(r"^address: (\d+)", (SUITES / manual / "device.yaml").read_text(), re.MULTILINE)[1]
            ours, link = ["--pty", f"{self.folder}/line", "--address", address], f"serial:{self.folder}/line"
        else:
            ours, link = ["--socket", f"listen:{self.folder}/wire"], f"socket:{self.folder}/wire"
        if kind == "pty":
            gsd = description_of(manual, variant, "*.gsd")
            text = SLAVE.format(manual=manual, variant=variant, link=link, control=control, gsd=gsd)
        else:
            gsdml, pages = description_of(manual, variant, "GSDML-*.xml"), PAGES.get(manual, "")
            text = BENCH.format(manual=manual, variant=variant, link=link, control=control, gsdml=gsdml, pages=pages)
        (self.folder / "bench.yaml").write_text(text + bench)
        serve = [BINARY, "serve", f"model:{manual}/{variant}", *ours, "--control", control, *deviations]
        self.server = self.start(serve, "serve.log")
        until = time.monotonic() + 60
        while "ready" not in (self.folder / "serve.log").read_text():
            if self.server.poll() is not None or time.monotonic() > until:
                raise RuntimeError(f"the served device is not ready: {(self.folder / 'serve.log').read_text()}")
            time.sleep(0.05)

    def start(self, command, name):
        with open(self.folder / name, "w") as log:
            return subprocess.Popen(command, stdout=log, stderr=log, cwd=self.folder)

    def run(self, words, patience):
        """The report of a run against this device; a text where there is none."""
        report = self.folder / "live.json"
        report.unlink(missing_ok=True)
        run = self.start([BINARY, "run", "--dut", "bench.yaml", *words, "--report", "json=live.json"], "run.log")
        try:
            run.wait(patience)
        except subprocess.TimeoutExpired:
            run.kill()
            run.wait()
            return f"it was not done after {patience} s"
        if not report.exists() or report.stat().st_size == 0:
            return f"no report: {(self.folder / 'run.log').read_text()[-400:]}"
        return json.loads(report.read_text())["runs"][0]

    def close(self):
        """Ends it; the link to it goes too."""
        self.server.terminate()
        try:
            self.server.wait(10)
        except subprocess.TimeoutExpired:
            self.server.kill()
        if self.interface:
            ip("link", "del", self.interface)


@contextlib.contextmanager
def served(device, deviations=(), bench=""):
    """Serves a device for a while; gives what runs something against it."""
    try:
        one = Served(device, deviations, bench)
    except (RuntimeError, subprocess.CalledProcessError) as error:
        why = str(error)
        yield lambda words, patience: why
        return
    try:
        yield one.run
    finally:
        one.close()


def daily_sample(items, parts):
    """One of so many parts of a list: that of the day, the one of the number in ENCSPEC_SAMPLE, or everything for `all`."""
    number = day.number()
    return items if number is None else items[number % parts::parts]


def at_once(count, work, items):
    with concurrent.futures.ThreadPoolExecutor(count) as pool:
        return list(pool.map(work, items))


def as_done(count, work, items):
    """Each item with the result of the work on it, as soon as that is done."""
    with concurrent.futures.ThreadPoolExecutor(count) as pool:
        working = {pool.submit(work, item): item for item in items}
        for done in concurrent.futures.as_completed(working):
            yield working[done], done.result()


def virtual(*words):
    """The devices of a report of the virtual wire."""
    command = [BINARY, "run", "--no-evidence", *words, "--report", "json=-"]
    return json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=False).stdout)["runs"]
