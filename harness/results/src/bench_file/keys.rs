//! The keys of a bench file.

use super::line::Driver;
use station::Parity;
use suite_yaml::device_yaml::PATH;
use suite_yaml::key_set;
use suite_yaml::keys::{Pattern, WordChoices};
use suite_yaml::persona::STATION_NAME;
use wire::profibus::fdl::BaudRate;

/// Parities of a serial line.
pub(super) static PARITIES: WordChoices<Parity> =
    WordChoices(&[("even", Parity::Even), ("odd", Parity::Odd), ("none", Parity::None)]);
/// What switches the driver of an RS-485 adapter.
pub(super) static DRIVERS: WordChoices<Driver> = WordChoices(&[("adapter", Driver::Adapter), ("port", Driver::Port)]);
/// Where a device is: a network interface, a socket or a serial line.
static LINK: Pattern = Pattern { regex: r"^(nic|socket|serial):.+$" };
/// A MAC address.
static MAC: Pattern = Pattern { regex: r"^[0-9A-Fa-f]{2}([:-][0-9A-Fa-f]{2}){5}$" };
/// An IPv4 address.
static IP: Pattern = Pattern { regex: r"^(0|[1-9][0-9]{0,2})(\.(0|[1-9][0-9]{0,2})){3}$" };
/// A firmware version: three numbers.
static FIRMWARE: Pattern = Pattern { regex: r"^[0-9]+\.[0-9]+\.[0-9]+$" };
/// How the shaft can be moved.
static SHAFT: Pattern = Pattern { regex: r"^(hand|(position|speed)\((\u00b1|\+/-) *[0-9.]+\))$" };
/// The rates of PROFIBUS in bits per second.
static BAUD_RATES: [u32; BaudRate::STANDARD.len()] = {
    let mut rates = [0; BaudRate::STANDARD.len()];
    let mut at = 0;
    while at < rates.len() {
        rates[at] = BaudRate::STANDARD[at].0 as u32;
        at += 1;
    }
    rates
};

key_set! {
    pub bench "a bench file" {
        device must Text, "The manual and the variant that it claims to be, as `manual/variant`; `none` for a device without a manual.";
        description may Text, "With `device: none`: a file that describes it in the words of device.yaml.";
        link must Pattern(&LINK), "Where it is: `nic:INTERFACE`, `socket:ADDRESS` for Ethernet frames on a stream as QEMU has them, or `serial:TTY` for a PROFIBUS.";
        line may Keys(&bench_line::KEYS), "What the PROFIBUS at a serial line is like.";
        station_name may Pattern(&STATION_NAME), "Its station name; without it the only station that fits the claim is meant.";
        mac may Pattern(&MAC), "Its MAC address, where it has to be this one.";
        ip may Pattern(&IP), "The address that it is given; without it the one that it has.";
        mask may Pattern(&IP), "The mask of the segment, 255.255.255.0 by default.";
        controller may Keys(&bench_controller::KEYS), "Our own addresses on the segment.";
        cycle may Time, "The cycle of connections that say none.";
        watchdog may Time, "The watchdog of connections that say none.";
        persona may Name, "In the manner of which controller the device is addressed; that of the command line wins.";
        boot_time may Time, "From power to an answer, at most, where it differs from the manual.";
        gsdml may Text, "The vendor's GSDML, a file (PROFINET).";
        gsd may Text, "The vendor's GSD, a file (PROFIBUS).";
        telegrams may NonEmpty(&Text), "The modules that it supports, by their names in device.yaml; all by default.";
        lacks may NonEmpty(&Text), "Records and parameters of device.yaml that it does not have.";
        firmware may Pattern(&FIRMWARE), "The firmware that it is said to have, as I&M0 tells it: `1.1.0`.";
        ledger may Text, "The ledger of its known failures, a file.";
        direct_cable may Flag, "Our cable ends at the device, with no switch between, at which LLDP stops; `true` or left out.";
        position_noise may Whole(0, 0xFFFF_FFFF), "By how many steps a place may differ, because the shaft is never quite still; 0 by default.";
        pages may Map(&Keys(&bench_page::KEYS)), "Its web pages whose looks the manual does not print, as they are on this device.";
        stand may Keys(&bench_stand::KEYS), "What holds it; without it nobody does.";
        consent may Keys(&bench_consent::KEYS), "What may be done to it that lasts; without it nothing.";
    }
}

key_set! {
    pub(super) bench_page "a web page of a bench" {
        path may Pattern(&PATH), "Where it is; without it where device.yaml says.";
        fields may Map(&Text), "The fields of its form that have other names than in device.yaml.";
        shows may Map(&Text), "The texts in front of its values, where they are others.";
    }
}

key_set! {
    pub(super) bench_controller "controller" {
        ip may Pattern(&IP), "Our IP address; without it one of the subnet that nobody has.";
        mac may Pattern(&MAC), "Our MAC address; without it one derived from the interface's.";
    }
}

key_set! {
    pub(super) bench_line "line" {
        baud may Numbers(&BAUD_RATES), "Bits in a second, 1500000 by default on a pseudoterminal and 19200 on any other line.";
        parity may Word(&PARITIES), "The parity bit; PROFIBUS has `even`, the default.";
        slot_time may Whole(1, 1_000_000), "How many bit times an answer is waited for; by default those of the standard, and 20 ms at least.";
        max_tsdr may Whole(1, 1_000_000), "How many bit times a slave takes to answer at most; by default those of the standard.";
        driver may Word(&DRIVERS), "Which hardware switches the driver of the RS-485 adapter; needed on any line but a pseudoterminal.";
        echo may Flag, "The adapter lets what we send come back; `true` or left out.";
        address may Whole(0, 126), "The station address that the device has, by default that of device.yaml.";
        masters may Between(2, 2, &Whole(0, 125)), "The addresses of our masters, `[1, 2]` by default.";
    }
}

key_set! {
    pub(super) bench_stand "stand" {
        control may Text, "A Unix socket that understands the control lines, as `encspec serve --control` makes one.";
        hooks may Names(&FilledText), "For a name that is set or looked at, the command that does it; `{value}` stands for the value.";
        ask may NonEmpty(&Text), "Names that somebody sets who is asked at the terminal.";
        shaft may NonEmpty(&Pattern(&SHAFT)), "How the shaft can be moved: `hand`, `position(\u{b1}STEPS)`, `speed(\u{b1}RPM)`.";
    }
}

key_set! {
    pub(super) bench_consent "consent" {
        factory_reset may Flag, "It may be reset to factory settings.";
        set_name may Flag, "Its station name may be changed; it is put back.";
        set_ip may Flag, "Its address may be changed; it is put back.";
        set_address may Flag, "Its station address may be changed over the bus; it is put back (PROFIBUS).";
        nvm_write may Whole(0, 0xFFFF_FFFF), "So many times in a run its memory may be written, 0 by default.";
        position_reference may Flag, "Its position may be preset: a machine around it loses its reference.";
        firmware may Flag, "It may be told to wait for another firmware, which stops its web server.";
        alone may Flag, "Nothing else is on the segment that could be disturbed.";
    }
}

/// The names that hooks can serve, and what the command is given or has to answer.
pub const HOOKS: &[(&str, &str)] = &[
    ("power", "`{value}` is up or down"),
    ("link", "`{value}` is up or down"),
    ("shaft.speed", "`{value}` in revolutions per minute, clockwise positive"),
    ("shaft.acceleration", "`{value}` in revolutions per minute, reached by `{acceleration}` of them each second"),
    ("shaft.counts", "`{value}` is a raw place in hardware steps"),
    ("turn", "`{value}` is the way, `{unit}` is counts or revolutions, `{rpm}` the speed"),
    ("supply.voltage", "`{value}` in volts"),
    ("supply.temperature", "`{value}` in degrees Celsius"),
    ("fault.NAME", "`{value}` is present or absent"),
    ("button.NAME", "`{value}` is pressed or released"),
    ("switch.NAME", "`{value}` is the position"),
    ("led.NAME", "the first line that it writes is what the LED shows, in a word of device.yaml"),
    ("counter.NAME", "the first line that it writes is the number"),
    ("renew", "puts a device as delivered into its place, with the same name and address"),
    (
        "device",
        "`{value}` is as_delivered: the device loses its address and everything stored, and has the name that it was delivered with, if any",
    ),
    ("clock", "`{value}` seconds go by for the device at once"),
];
