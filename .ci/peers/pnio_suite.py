#!/usr/bin/env python3
"""Our controller against the device of the crate pnio: the suite for any PROFINET IO device, and what it finds.

    pnio_suite.py ENCSPEC BENCH APPROVED [FILTER]

Runs a fifth of the suite, another one each day, on the bench of BENCH (ENCSPEC_SAMPLE=all: everything; ENCSPEC_SAMPLE=N: the fifth of
that day; with FILTER all of what it names) and compares every verdict, and what was expected and observed where it is no pass, with the approved
text APPROVED. With APPROVE=1 in the environment the text is written instead, to be read and committed. What pnio lacks stands in it as a
finding: a run that is red is no failure here, one that finds something else is. A case with another verdict is run
again by itself, a few times at most, since a host that stalls spoils it; so is an inconclusive one.
"""

import difflib
import json
import os
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]
import common as who  # noqa: E402
import day  # noqa: E402


def lines_of(case):
    """A case in the lines of the approved text."""
    lines = [f"{case['verdict']:<14} {case['id']}"]
    if case["verdict"] == "not-applicable":
        lines.append(f"    {case['reason']}")
    for part in (case["failure"] or {}).get("parts", []):
        if not part["held"]:
            lines.append(f"    {part['text']}: expected {part['expected']}, observed {part['seen']}")
    return lines


def is_the_same(case, approved):
    """Whether a case has the approved verdict.

    What a device does wrong for seconds cannot be observed without a stall where the host stalls every few seconds: where all that
    was approved and seen is what is approved as a failure, and only our being late kept it from being called so, it is the same.
    """
    first, *parts = lines_of(case)
    is_late = case["verdict"] == "inconclusive" and "the harness was" in (case["reason"] or "")
    return [first, *parts] == approved or bool(is_late and parts and approved and approved[0].startswith("fail ") and parts == approved[1:])


# How often a case is run again.
ATTEMPTS = 6


def suite(command):
    """The results of a run by the ids of the cases."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=900)
    if done.returncode not in (0, 1):
        who.check("the suite runs", done.stderr.strip(), "")
        who.finish()
    return {case["id"]: case for case in json.loads(done.stdout)["runs"][0]["cases"]}


# Topics whose findings on pnio were not read and approved yet; they are not run, and the output says so.
NOT_READ_YET = [f"protocol-{topic}/" for topic in (
    "dcp", "transactions", "station", "record-refusals", "record-contents", "diagnosis-records", "im-records", "rpc", "data-status",
    "neighbours", "alarm-transfer", "interruptions", "snmp", "shared", "plug", "ports", "supervisor", "process-alarms", "ping",
    "load", "connection-records", "hello")]
# One of so many parts runs each day.
PARTS = 5


def part_of_the_day():
    """The words that run the part of the day; none where everything runs."""
    number = day.number()
    if number is None or os.environ.get("APPROVE") == "1":
        return []
    return ["--part", f"{number % PARTS + 1}/{PARTS}"]


def approved_of(text):
    """The lines of each case of an approved text, by their ids."""
    cases, last = {}, []
    for line in text.splitlines():
        if not line.startswith(" "):
            last = cases[line.split()[-1]] = []
        last.append(line)
    return cases


def main():
    encspec, bench, approved_file, *some = sys.argv[1:]
    # This script repeats what a stall has spoilt; a case that waits two minutes for what pnio never sends would be repeated by the run as well.
    command = [encspec, "run", "--dut", bench, "--no-evidence", "--stall-repeats", "0", "--report", "json=-"]
    part = [] if some else part_of_the_day()
    if part:
        some = [f"!{topic}" for topic in NOT_READ_YET]
        print(f"# findings of {len(NOT_READ_YET)} topics were not read yet, so they are not run here: {' '.join(NOT_READ_YET)}")
    # What decides a rule may be in another part.
    cases = {id: case for id, case in suite([*command, *some, *part]).items() if not part or case["kind"] == "case"}
    path = pathlib.Path(approved_file)
    before = path.read_text() if path.exists() else ""
    approved = approved_of(before)
    if part:
        listed = json.loads(subprocess.run([encspec, "list", "profinet-io", "--format", "json"], stdout=subprocess.PIPE, check=True).stdout)
        who.check("every approved case is in the suite", sorted(set(approved) - {case["id"] for case in listed["manuals"][0]["cases"]}), [])
        before = "".join("\n".join(approved[id]) + "\n" for id in approved if id in cases)
    # An inconclusive case that is approved stays one; once more tells whether a stall was the reason.
    for _ in range(1 if os.environ.get("APPROVE") == "1" else ATTEMPTS):
        other = [case for case in cases.values() if case["kind"] == "case" and not is_the_same(case, approved.get(case["id"]))]
        if os.environ.get("APPROVE") == "1":
            other = [case for case in other if case["verdict"] == "inconclusive"]
        for case in other:
            cases[case["id"]] = suite([*command, case["id"], "--exact"])[case["id"]]
    if os.environ.get("APPROVE") != "1":
        late = [case["id"] for case in cases.values() if is_the_same(case, approved.get(case["id"])) and lines_of(case) != approved[case["id"]]]
        for id in late:
            print(f"# the approved failure was observed while the harness was late: {id}")
    lines = [line for case in cases.values()
             for line in (approved[case["id"]] if is_the_same(case, approved.get(case["id"])) else lines_of(case))]
    text = "\n".join(lines) + "\n"
    if os.environ.get("APPROVE") == "1":
        path.write_text(text)
    else:
        for line in difflib.unified_diff(before.splitlines(), lines, "approved", "found", lineterm="", n=1):
            print(f"# {line}")
        who.check(f"{path.name} says what is found", text == before, True)
    who.finish()


main()
