//! Tests that affect a whole process: privileges, interrupts, real-time settings. Each test runs in its own process, which this
//! program starts by calling itself.

use std::env;
use std::fs;
use std::io::{BufRead, BufReader, Write as _};
use std::process::{Child, Command, ExitCode, Stdio};
use std::sync::mpsc::channel;
use std::thread;

use encspec_link::{Clock, LinkError, Nic, Port, interrupt, namespace, privileges, realtime};
use libtest_mimic::{Arguments, Failed, Trial};
use station::{Duration, Time};

/// The environment variable with the name of the test that a child process has to run.
const PART: &str = "ENCSPEC_TEST_PART";
/// The exit status of a child process whose test cannot run on this host.
const SKIPPED: u8 = 77;

/// How long a child process waits for the second interrupt.
const END_TIMEOUT: Duration = Duration::from_secs(20);

/// The user and group `nobody`, which every system has.
const NOBODY: &str = "65534";

type ChildTest = fn() -> Result<(), String>;

const PARTS: [(&str, ChildTest); 7] = [
    ("raw_sockets_are_dropped_and_open_ones_still_work", raw_sockets_are_dropped),
    ("under_sudo_the_process_changes_to_the_calling_user", changes_to_the_calling_user),
    ("a_thread_that_keeps_its_privileges_is_reported", another_thread_is_reported),
    ("granted_real_time_settings_are_reported_and_memory_can_be_allocated", real_time_settings),
    ("memory_that_was_locked_under_sudo_can_still_grow", memory_after_sudo),
    ("without_privileges_no_setting_is_granted_and_everything_works", real_time_settings_without_privileges),
    ("children_of_a_real_time_thread_are_ordinary", ordinary_children),
];

/// The tests whose environment looks as if the user `nobody` had called `sudo`.
const AS_UNDER_SUDO: [&str; 3] = [
    "under_sudo_the_process_changes_to_the_calling_user",
    "memory_that_was_locked_under_sudo_can_still_grow",
    "without_privileges_no_setting_is_granted_and_everything_works",
];

fn main() -> ExitCode {
    if let Ok(part) = env::var(PART) {
        return play(&part);
    }
    let mut trials: Vec<_> = PARTS.iter().map(|(name, _)| Trial::test(*name, || in_a_process(name))).collect();
    trials.push(Trial::test("the_first_interrupt_requests_a_stop_and_the_second_ends_the_process", interrupts));
    libtest_mimic::run(&Arguments::from_args(), trials).exit_code()
}

fn play(part: &str) -> ExitCode {
    if part == "interrupts" {
        return wait_for_interrupts();
    }
    let Some((_, part)) = PARTS.iter().find(|(name, _)| *name == part) else { return ExitCode::from(2) };
    if let Err(why) = namespace::enter_private_network().and_then(|()| namespace::veth("left", "right")) {
        eprintln!("{why}");
        return ExitCode::from(SKIPPED);
    }
    match part() {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}

fn myself(part: &str) -> Result<Command, Failed> {
    let mut command = Command::new(env::current_exe()?);
    command.env(PART, part).env_remove("SUDO_UID").env_remove("SUDO_GID");
    if AS_UNDER_SUDO.contains(&part) {
        command.env("SUDO_UID", NOBODY).env("SUDO_GID", NOBODY);
    }
    Ok(command)
}

fn in_a_process(part: &str) -> Result<(), Failed> {
    let output = myself(part)?.output()?;
    let text = String::from_utf8_lossy(&output.stderr).trim().to_string();
    match output.status.code() {
        Some(0) => Ok(()),
        Some(code) if code == i32::from(SKIPPED) && env::var_os("ENCSPEC_REQUIRE_ALL").is_none() => {
            eprintln!("skipped: {text}");
            Ok(())
        }
        _ => Err(format!("{}: {text}", output.status).into()),
    }
}

fn ensure(holds: bool, what: &str) -> Result<(), String> {
    if holds { Ok(()) } else { Err(format!("not true: {what}")) }
}

fn text(error: LinkError) -> String {
    error.to_string()
}

/// Sends a frame from one interface to the other and checks that it arrives.
fn crosses(from: &mut Nic, to: &mut Nic) -> Result<(), String> {
    let clock = Clock::start();
    let sent = [[0xFF; 12].as_slice(), &[0x88, 0xB5], &[7; 46]].concat();
    from.send(&sent).map_err(text)?;
    let mut frame = Vec::new();
    let arrived = to.receive(&clock, clock.now() + Duration::from_secs(60), &mut frame).map_err(text)?;
    ensure(arrived.is_some() && frame == sent, "the frame crosses the cable")
}

fn both() -> Result<(Nic, Nic), String> {
    Ok((Nic::open("left").map_err(text)?, Nic::open("right").map_err(text)?))
}

/// The effective and permitted capabilities of this thread, read from `/proc`.
fn capabilities() -> Result<String, String> {
    let status = fs::read_to_string("/proc/thread-self/status").map_err(|error| error.to_string())?;
    let lines = status.lines().filter(|line| line.starts_with("CapEff") || line.starts_with("CapPrm"));
    Ok(lines.map(|line| line.split_whitespace().last().unwrap_or_default()).collect::<Vec<_>>().join(" "))
}

/// A child process that keeps the privileges and runs `script` when it receives a line.
fn keeper(script: &str) -> Result<Child, String> {
    let mut shell = Command::new("sh");
    shell.args(["-c", &format!("read line; {script}")]).stdin(Stdio::piped());
    shell.spawn().map_err(|error| error.to_string())
}

fn raw_sockets_are_dropped() -> Result<(), String> {
    let (mut left, mut right) = both()?;
    let mut keeper = keeper(
        "ip link del left; ip link add left type veth peer name right; ip link set left up; ip link set right up",
    )?;
    ensure(privileges::has_raw_sockets(), "the privilege is there before")?;
    privileges::drop().map_err(text)?;
    ensure(!privileges::has_raw_sockets(), "the privilege is gone")?;
    // CAP_DAC_OVERRIDE and CAP_IPC_LOCK, numbers 1 and 14.
    let expected = "0000000000004002 0000000000004002";
    ensure(capabilities()? == expected, &capabilities()?)?;
    let in_a_thread = thread::spawn(capabilities).join().map_err(|_| "the thread ends".to_string())??;
    ensure(in_a_thread == expected, "also in a thread that starts later")?;
    crosses(&mut left, &mut right)?;

    let why = text(Nic::open("left").err().ok_or("a new socket can be opened")?);
    let program = env::current_exe().map_err(|error| error.to_string())?;
    let advice = format!(
        "the interface left needs root or CAP_NET_RAW: grant it with \
         `sudo setcap cap_net_raw,cap_sys_nice,cap_ipc_lock=ep {}`, or run as root",
        program.display()
    );
    ensure(why == advice, &why)?;

    // The interfaces are replaced by others with the same names: an open socket is enough to use them.
    drop(keeper.stdin.take().map(|mut line| writeln!(line)));
    keeper.wait().map_err(|error| error.to_string())?;
    let clock = Clock::start();
    let until = clock.now() + Duration::from_secs(5);
    for nic in [&mut left, &mut right] {
        ensure(nic.receive(&clock, until, &mut Vec::new()).is_err(), "it was removed")?;
        nic.recover(&clock, until).map_err(text)?;
    }
    crosses(&mut left, &mut right)?;
    privileges::drop().map_err(text)
}

fn changes_to_the_calling_user() -> Result<(), String> {
    let (mut left, mut right) = both()?;
    let (_end, waits) = channel::<()>();
    let other = thread::spawn(move || waits.recv().is_err());
    privileges::drop().map_err(text)?;
    let tasks = fs::read_dir("/proc/self/task").map_err(|error| error.to_string())?;
    let mut checked = 0;
    for task in tasks.flatten() {
        let status = fs::read_to_string(task.path().join("status")).map_err(|error| error.to_string())?;
        for name in ["Uid:", "Gid:", "Groups:"] {
            let values = status.lines().find_map(|line| line.strip_prefix(name)).unwrap_or_default();
            ensure(values.split_whitespace().all(|value| value == NOBODY), &format!("{name} {values}"))?;
        }
        checked += 1;
    }
    ensure(checked == 2 && !other.is_finished(), "both threads were checked")?;
    ensure(capabilities()? == "0000000000000000 0000000000000000", "no capability is left")?;
    crosses(&mut left, &mut right)?;
    ensure(Nic::open("left").is_err_and(|error| error.to_string().contains("setcap")), "no new socket")?;
    privileges::drop().map_err(text)
}

fn another_thread_is_reported() -> Result<(), String> {
    let (_end, waits) = channel::<()>();
    let other = thread::spawn(move || waits.recv().is_err());
    let error = privileges::drop().err().ok_or("the other thread went unnoticed")?;
    ensure(!other.is_finished(), "the other thread runs")?;
    let why = "a thread of this process keeps its privileges: drop them before starting threads";
    ensure(error == LinkError::Unusable(why.to_string()), &error.to_string())
}

/// The field of `/proc/PID/stat` with the scheduling policy, counted from 1, see `proc(5)`.
const POLICY_FIELD: usize = 41;

/// The scheduling policy of the calling thread: 0 for ordinary, 1 for SCHED_FIFO.
fn policy() -> Result<String, String> {
    let stat = fs::read_to_string("/proc/thread-self/stat").map_err(|error| error.to_string())?;
    // The name in parentheses may hold spaces; what follows starts with field 3.
    let (_, fields) = stat.rsplit_once(')').ok_or("no fields")?;
    Ok(fields.split_whitespace().nth(POLICY_FIELD - 3).unwrap_or_default().to_string())
}

fn locked_memory() -> Result<u64, String> {
    let status = fs::read_to_string("/proc/self/status").map_err(|error| error.to_string())?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmLck:")).ok_or("no figure of locked memory")?;
    line.trim().trim_end_matches(" kB").parse().map_err(|_| line.to_string())
}

/// Allocates memory of all kinds: new, grown, and a deep stack.
fn memory_can_be_allocated() -> Result<(), String> {
    fn deep(left: u32) -> u64 {
        let page = std::hint::black_box([left; 1024]);
        if left == 0 { 0 } else { deep(left - 1) + u64::from(page[7]) }
    }
    let mut block = vec![1_u8; 32 << 20];
    block.resize(64 << 20, 2);
    ensure(block[(64 << 20) - 1] == 2 && deep(1000) == 500_500, "memory is there")
}

fn real_time_settings() -> Result<(), String> {
    let settings = realtime::raise();
    let expected = ["real-time scheduling (SCHED_FIFO, priority 40)", "memory locked"];
    ensure(settings.granted == expected && settings.refused.is_empty(), &format!("{settings:?}"))?;
    ensure(policy()? == "1", "the kernel reports SCHED_FIFO")?;
    ensure(locked_memory()? > 0, "the kernel has locked memory")?;
    privileges::drop().map_err(text)?;
    ensure(policy()? == "1", "SCHED_FIFO stays after dropping privileges")?;
    memory_can_be_allocated()
}

fn memory_after_sudo() -> Result<(), String> {
    realtime::raise();
    privileges::drop().map_err(text)?;
    ensure(policy()? == "1", "the kernel still reports SCHED_FIFO")?;
    memory_can_be_allocated()
}

fn real_time_settings_without_privileges() -> Result<(), String> {
    privileges::drop().map_err(text)?;
    let settings = realtime::raise();
    let [ordinary, limited @ ..] = settings.refused.as_slice() else { return Err(format!("{settings:?}")) };
    ensure(ordinary.starts_with("no real-time scheduling, CAP_SYS_NICE is missing ("), ordinary)?;
    let expected = "memory not locked, CAP_IPC_LOCK is missing: grant it with `setcap`, or run as root";
    ensure(limited == [expected] || settings.granted == ["memory locked"], &format!("{settings:?}"))?;
    ensure((limited == [expected]) == (locked_memory()? == 0), "the report agrees with the kernel")?;
    memory_can_be_allocated()
}

fn ordinary_children() -> Result<(), String> {
    realtime::raise();
    let in_a_thread = thread::spawn(policy).join().map_err(|_| "the thread ends".to_string())??;
    ensure(in_a_thread == "0", "a thread is ordinary")?;
    let shell = Command::new("cat").arg("/proc/self/stat").output().map_err(|error| error.to_string())?;
    let stat = String::from_utf8_lossy(&shell.stdout).into_owned();
    ensure(stat.split_whitespace().nth(POLICY_FIELD - 1) == Some("0"), "a command is ordinary")
}

/// Prints `ready`, then `requested` after the first interrupt, and runs on until a second interrupt ends it.
fn wait_for_interrupts() -> ExitCode {
    interrupt::watch();
    interrupt::watch();
    if interrupt::requested() {
        return ExitCode::from(3);
    }
    println!("ready");
    while !interrupt::requested() {
        thread::yield_now();
    }
    println!("requested");
    let clock = Clock::start();
    while clock.now() < Time::ZERO + END_TIMEOUT {
        thread::yield_now();
    }
    ExitCode::from(4)
}

fn interrupts() -> Result<(), Failed> {
    for (first, second) in [("INT", "INT"), ("TERM", "INT")] {
        let mut child = myself("interrupts")?.stdout(Stdio::piped()).spawn()?;
        let mut lines = BufReader::new(child.stdout.take().ok_or("no output")?).lines();
        let process = child.id().to_string();
        let kill = |signal: &str| Command::new("kill").args(["-s", signal, &process]).status();
        let mut printed = vec![lines.next().transpose()?];
        kill(first)?;
        printed.push(lines.next().transpose()?);
        kill(second)?;
        let status = child.wait()?;
        let printed: Vec<_> = printed.iter().flatten().map(String::as_str).collect();
        if printed != ["ready", "requested"] || status.code() != Some(130) {
            return Err(format!("{first} and {second}: printed {}; {status}", printed.join(", ")).into());
        }
    }
    Ok(())
}
