//! The web pages, asked without a network.

use super::*;
use wire::profidrive::{ParameterAddress, Request};

/// What is seen of the web server on a walk through all of its pages.
pub(super) fn walk(seen: &mut Vec<u64>, bug: Option<&Behaviour>) {
    let mut bench = Bench::alone(MULTITURN, bug, 0x0123_4567);
    let mut look = |bench: &mut Bench| {
        seen.push(bench.encoder.serves_pages().into());
        for path in ["/", "/information.htm", "/parameters.htm", "/position.htm", "/preset.htm"] {
            let (status, page) = bench.page(path);
            seen.push(status.into());
            seen.extend(page.bytes().map(u64::from));
        }
        seen.extend((0..30).map(|_| u64::from(bench.frame().xist1)));
        seen.extend(bench.preset_value_in_octets().into_iter().map(u64::from));
    };
    look(&mut bench);
    for (bits, units, range) in [(0x2B, 4096, 1 << 24), (0x22, 65536, 1 << 30)] {
        bench.connect(81, &record(bits, units, range)).ok();
        bench.act(StandAction::ShaftSpeed(60.0));
        look(&mut bench);
    }
    let mut say = Vec::new();
    for entry in ["1000", "1000", "0x20", "G", "", "123456789"] {
        say.extend(bench.enter(entry).bytes().map(u64::from));
        look(&mut bench);
    }
    bench.power_cycle();
    look(&mut bench);
    for password in ["LIKA", "lika"] {
        say.extend(bench.send("/upgrade.htm", "password", password).bytes().map(u64::from));
        look(&mut bench);
    }
    seen.append(&mut say);
}

impl Bench {
    /// The answer to a read of P65000, which a bug may have made unreadable.
    fn preset_value_in_octets(&mut self) -> Vec<u8> {
        let (mut request, mut answer) = (Vec::new(), Vec::new());
        Request::read_values(7, 1, [ParameterAddress::value(65000, 0)].to_vec()).write(&mut request);
        let written = self.encoder.write_record(self.now, access(0xB02E), &request);
        let read = self.encoder.read_record(self.now, access(0xB02E), &mut answer);
        answer.extend([written, read].map(|done| u8::from(done.is_ok())));
        answer
    }
}
