//! The keys of a bench file.

use super::DcpPermanence;
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
/// Where a device is: a network interface, a socket, a serial line or a program.
static LINK: Pattern = Pattern { regex: r"^(nic|socket|serial|app):.+$" };
/// Whether the device stores its IP address.
pub(super) static PERMANENCES: WordChoices<DcpPermanence> =
    WordChoices(&[("permanent", DcpPermanence::Permanent), ("temporary", DcpPermanence::Temporary)]);
/// A MAC address.
static MAC: Pattern = Pattern { regex: r"^[0-9A-Fa-f]{2}([:-][0-9A-Fa-f]{2}){5}$" };
/// An IPv4 address.
static IP: Pattern = Pattern { regex: r"^(0|[1-9][0-9]{0,2})(\.(0|[1-9][0-9]{0,2})){3}$" };
/// A firmware version: three numbers.
static FIRMWARE: Pattern = Pattern { regex: r"^[0-9]+\.[0-9]+\.[0-9]+$" };
/// How the shaft can be moved.
static SHAFT: Pattern = Pattern { regex: r"^(hand|uncoupled|(position|speed)\((\u00b1|\+/-) *[0-9.]+\))$" };
/// The rates of PROFIBUS in bits per second.
static BAUD_RATES: [u32; BaudRate::STANDARD.len()] = {
    let mut rates = [0; BaudRate::STANDARD.len()];
    let mut at = 0;
    while at < rates.len() {
        rates[at] = BaudRate::STANDARD[at].0;
        at += 1;
    }
    rates
};

key_set! {
    pub bench "a bench file" {
        device must Text, "The manual and the variant that it claims to be, as `manual/variant`; `none` for a device without a manual.";
        description may Text, "With `device: none`: a file that describes the device with the keys of device.yaml.";
        link must Pattern(&LINK), "The link to the device: `nic:INTERFACE`, `socket:ADDRESS` for Ethernet frames on a stream like QEMU's, `serial:TTY` for PROFIBUS, or `app:COMMAND` for a program that is the application of the device on either bus.";
        line may Keys(&bench_line::KEYS), "Settings of PROFIBUS at a serial line.";
        station_name may Pattern(&STATION_NAME), "Its station name; by default the only station that fits the claimed device.";
        mac may Pattern(&MAC), "Its MAC address, if only this one may be tested.";
        ip may Pattern(&IP), "The IP address to assign; by default the device keeps its own.";
        mask may Pattern(&IP), "The subnet mask, 255.255.255.0 by default.";
        ip_permanence may Word(&PERMANENCES), "Whether the device has stored the IP address that it has before the run, which DCP cannot read; without this key the address is put back as a permanent one.";
        controller may Keys(&bench_controller::KEYS), "The addresses of encspec on the subnet.";
        cycle may Time, "The cycle time of connections that name none.";
        watchdog may Time, "The watchdog time of connections that name none.";
        persona may Name, "The persona: the controller whose behaviour encspec imitates; `--persona` on the command line takes precedence.";
        boot_time may Time, "The longest time from power-on to an answer, if it differs from the manual.";
        timing may Map(&Quantity), "Times of ours that are others on this bench, by the names of `timing` of device.yaml; `patience` is the factor up to which slowness is only noted.";
        tolerance may Map(&Quantity), "Tolerances of ours that are others on this bench, by the names of `tolerance` of device.yaml.";
        gsdml may Text, "The vendor's GSDML, a file (PROFINET).";
        gsd may Text, "The vendor's GSD, a file (PROFIBUS).";
        gsd_module may Text, "With `device: none`: the module of the GSD that the slave has, by its name there (PROFIBUS).";
        start_parameters may Map(&FilledText), "Start parameters of device.yaml, each with its name in the GSDML or GSD, where the names or values leave a doubt.";
        telegrams may NonEmpty(&Text), "The modules that the device supports, by their names in device.yaml; all by default.";
        lacks may NonEmpty(&Text), "Records and parameters of device.yaml that the device does not have.";
        firmware may Pattern(&FIRMWARE), "The expected firmware as in I&M0, for instance `1.1.0`.";
        ledger may Text, "The ledger of known failures, a file.";
        direct_cable may Flag, "The cable of encspec ends at the device, without a switch, which would stop LLDP; `true` or absent.";
        position_noise may Whole(0, 0xFFFF_FFFF), "The steps by which a position may differ, since the shaft is never quite still; 0 by default.";
        pages may Map(&Keys(&bench_page::KEYS)), "Web pages whose layout the manual does not print, as they are on this device.";
        stand may Keys(&bench_stand::KEYS), "What controls power, shaft and faults; without it nothing does.";
        consent may Keys(&bench_consent::KEYS), "Lasting changes that are permitted; by default none.";
    }
}

key_set! {
    pub(super) bench_page "a web page of a bench" {
        path may Pattern(&PATH), "The path of the page; by default that of device.yaml.";
        fields may Map(&Text), "Fields of its form whose names differ from device.yaml.";
        shows may Map(&Text), "The texts in front of its values, if they differ from device.yaml.";
    }
}

key_set! {
    pub(super) bench_controller "controller" {
        ip may Pattern(&IP), "The IP address of encspec; by default an unused one of the subnet.";
        mac may Pattern(&MAC), "The MAC address of encspec; by default derived from that of the interface.";
    }
}

key_set! {
    pub(super) bench_line "line" {
        baud may Numbers(&BAUD_RATES), "Bits per second; by default 1500000 on a pseudoterminal and 19200 on any other line.";
        parity may Word(&PARITIES), "The parity bit; PROFIBUS has `even`, the default.";
        slot_time may Whole(1, 1_000_000), "The slot time in bit times; by default that of the standard, and at least 20 ms.";
        max_tsdr may Whole(1, 1_000_000), "Max TSDR: the longest time of a slave to answer, in bit times; by default that of the standard.";
        driver may Word(&DRIVERS), "The hardware that switches the driver of the RS-485 adapter; required on any line but a pseudoterminal.";
        echo may Flag, "The adapter echoes what encspec sends; `true` or absent.";
        address may Whole(0, 126), "The station address of the device, by default that of device.yaml.";
        masters may Between(2, 2, &Whole(0, 125)), "The addresses of encspec's masters, `[1, 2]` by default.";
    }
}

key_set! {
    pub(super) bench_stand "stand" {
        control may Text, "A Unix socket that accepts control commands, like the one of `encspec serve --control`.";
        hooks may Names(&FilledText), "For each name that is set or read, the command that does it; `{value}` stands for the value.";
        ask may NonEmpty(&Text), "Names that a person sets when prompted at the terminal.";
        shaft may NonEmpty(&Pattern(&SHAFT)), "How the shaft can be moved: `hand`, `position(\u{b1}STEPS)`, `speed(\u{b1}RPM)`; `uncoupled`: nothing is driven by its position.";
    }
}

key_set! {
    pub(super) bench_consent "consent" {
        factory_reset may Flag, "The device may be reset to factory settings.";
        set_name may Flag, "The station name may be changed; it is restored afterwards.";
        set_ip may Flag, "The IP address may be changed; it is restored afterwards.";
        set_address may Flag, "The station address may be changed over the bus; it is restored afterwards (PROFIBUS).";
        im_records may Flag, "I&M1 to I&M4 (plant tags, date, descriptor, signature) may be overwritten; they are restored afterwards.";
        lock_address may Flag,
            "Set_Slave_Address may forbid further changes, so the device keeps a wrong address until a reset that the manual may not have (PROFIBUS).";
        nvm_write may Whole(0, 0xFFFF_FFFF), "The number of permitted writes to non-volatile memory per run, 0 by default.";
        position_reference may Flag, "The position may be preset; a machine that uses it loses its reference.";
        firmware may Flag, "The device may be made to wait for another firmware, which stops its web server.";
        overstress may Flag, "Supply and temperature may be set beyond what the manual permits, which can damage the device.";
        alone may Flag, "No other station is on the network that could be disturbed.";
    }
}

/// The names that hooks can serve, and what the command receives or must answer.
pub const HOOKS: &[(&str, &str)] = &[
    ("power", "`{value}` is up or down"),
    ("link", "`{value}` is up or down"),
    ("shaft.speed", "`{value}` in revolutions per minute, clockwise positive"),
    ("shaft.acceleration", "`{value}` in revolutions per minute, reached with `{acceleration}` rpm per second"),
    ("shaft.counts", "`{value}` is a raw position in hardware steps"),
    ("turn", "`{value}` is the distance, `{unit}` is counts or revolutions, `{rpm}` the speed"),
    ("supply.voltage", "`{value}` in volts"),
    ("supply.temperature", "`{value}` in degrees Celsius"),
    ("fault.NAME", "`{value}` is present or absent"),
    ("button.NAME", "`{value}` is pressed or released"),
    ("switch.NAME", "`{value}` is the position"),
    ("led.NAME", "the first line of output is what the LED shows, as a word of device.yaml"),
    ("counter.NAME", "the first line of output is the number"),
    ("renew", "replaces the device by one in factory state, with the same name and address"),
    (
        "device",
        "`{value}` is as_delivered: the device returns to factory state: no address, nothing stored, and the name of delivery, if any",
    ),
    ("clock", "the clock of the device advances by `{value}` seconds at once"),
];
