//! What the manual of the XAC77 leaves free in parameters, records, memory and web pages.

use super::xac77_signals;
use crate::needs::Need;
use crate::seams::Deviations;
use crate::seams::web::with_text;
use crate::tables::parameters::configured_scaling_always_shown;
use crate::tables::records::refuse;
use crate::tables::start::USER_PARAMETERS;
use crate::tables::{Deviation, Group};
use alloc::string::String;
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profinet::{RecordAccess, RecordRefusal, StackCheck};
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder_object::names::accepts;
use encoder_profile::encoder_object::{ENCODER_API, ENCODER_SLOT};
use encoder_profile::hooks::{EncoderView, RecordOctets};
use encoder_profile::profidrive::user_parameters::serves;
use reference_devices::manuals;
use wire::profidrive::{ParameterError, ParameterFormat, ParameterResponse, ParameterValue, RequestId};

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[
    Group { needs: &[Need::Of(&manuals::LIKA_XAC77)], deviations: PARAMETERS },
    Group { needs: &[Need::Of(&manuals::LIKA_XAC77)], deviations: RECORDS_AND_MEMORY },
    Group { needs: &[Need::Of(&manuals::LIKA_XAC77)], deviations: PAGES_AND_NAMES },
    Group { needs: &[Need::Of(&manuals::LIKA_XAC77)], deviations: xac77_signals::HANDSHAKES },
    Group { needs: &[Need::Of(&manuals::LIKA_XAC77)], deviations: xac77_signals::POSITIONS },
];

static PARAMETERS: &[Deviation] = permitted! {
    "operating-time-measured" "P65001 counts the operating time in tenths of an hour."
        "11.3 prints FFFFFFFFh for the operating time without explaining it"
        => |d| d.encoder.element(|view, at, right| if at == (65001, 7) && right == 0xFFFF_FFFF { view.now.as_nanos() / 360_000_000_000 } else { right });
    "configured-scaling-shown" "P65001 shows units and range of the record even while scaling is off."
        "11.3 names the elements and calls them variable; whether they show settings or values in use is not said"
        => |d| d.encoder.element(configured_scaling_always_shown);
    "operating-status-shows-effects" "The operating status shows a setting as 0 while it has no effect."
        "11.3, operating status table: whether a bit shows a setting or its effect is not said"
        => |d| d.encoder.element(|view, at, right| if at == (65001, 1) { status_in_effect(view, right) } else { right });
    "offset-in-twos-complement" "P65001 shows an offset above half of the range as a negative number."
        "11.3 declares the offset Unsigned32; its number range is not given"
        => |d| d.encoder.element(|view, at, right| if at == (65001, 8) && right > view.positions / 2 {
            right.wrapping_sub(view.positions) & 0xFFFF_FFFF
        } else {
            right
        });
    "sensor-format-of-the-scaling" "P979 shows the resolution and the revolutions of the scaling in force."
        "11.2, P979: the values are 'variable'"
        => |d| d.encoder.element(|view, at, right| {
            let scaling = view.measuring.settings.scaling;
            match at {
                (979, 2) => scaling.units_per_revolution,
                (979, 5) if view.hardware.revolutions > 1 => scaling.range.div_ceil(scaling.units_per_revolution.max(1)),
                _ => right,
            }
        });
    "singleturn-without-revolutions" "P979 of a singleturn encoder has 0 distinguishable revolutions."
        "11.2, P979: the value is 'variable'"
        => |d| d.encoder.element(|view, at, right| if at == (979, 5) && view.hardware.revolutions == 1 { 0 } else { right });
    "list-ends-with-zero" "P980 ends with an element 0."
        "PROFIdrive ends the list with 0; 11.2, P980, is silent about it"
        => |d| d.encoder.parameter(|_, number, mut parameter| {
            if number == 980 {
                parameter.values.push(0);
            }
            parameter
        });
    "p925-served" "P925 exists and reads 0."
        "11.4, compatibility table: P925 is optional"
        => |d| d.encoder.refuse(|id, number, error| error.filter(|_| id != RequestId::REQUEST || number != 925));
    "version-of-two-numbers" "P964 and P975 give version 1.1.0 as 101."
        "11.2, P964 and P975: 'xxxx' and 'xx.xx' without a coding"
        => |d| version(d, 101);
    "version-of-a-digit-and-a-number" "P964 and P975 give version 1.1.0 as 1100."
        "11.2, P964 and P975: 'xxxx' and 'xx.xx' without a coding"
        => |d| version(d, 1100);
    "version-in-bytes" "P964 and P975 give version 1.1.0 as 0101h."
        "11.2, P964 and P975: 'xxxx' and 'xx.xx' without a coding"
        => |d| version(d, 0x0101);
    "point-in-the-version-of-the-object" "P975 gives the version of P964 with a point between its bytes."
        "11.2, P975: printed 'xx.xx', against 'xxxx' of P964"
        => |d| d.encoder.element(|_, at, right| if at == (975, 2) { right / 100 * 256 + right % 100 } else { right });
    "date-in-bytes" "P964 and P975 give day and month in a byte each."
        "11.2, P964: 'dd.mm' without a coding"
        => |d| d.encoder.element(|_, at, right| if let (964 | 975, 4) = at { right / 100 * 256 + right % 100 } else { right });
    "profile-version-by-digits" "P965 gives the version with a digit in each half of the byte."
        "11.2, P965: 31 and 41 are printed without a prefix, beside 0x3D"
        => |d| d.encoder.element(|_, at, right| if at == (965, 1) { by_digits(right) } else { right });
    "type-codes-in-answers" "Answers have the codes of the data types, not those of their widths."
        "the manual is silent: PROFIdrive permits both (15 has only figures)"
        => |d| d.encoder.respond(|_, response| with_type_codes(response));
    "errors-with-a-subindex" "Each error is followed by the subindex at which it occurred."
        "the manual is silent: PROFIdrive makes it optional (15 has only figures)"
        => |d| d.encoder.refuse(|_, _, error| error.map(|error| ParameterError { subindex: error.subindex.or(Some(0)), ..error }));
    "one-parameter-at-a-time" "A request for several parameters is refused for each of them."
        "the manual is silent: 15 has only figures; PROFIdrive has error 23h for devices that serve one parameter per request"
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::ParameterCount(count) => right && count < 2,
            _ => right,
        });
    "any-axis-answered" "A request for any drive object is answered."
        "the manual is silent: PROFIdrive lets a device with one object ignore the number in local access"
        => |d| d.checks.check(|check, right| right || matches!(check, EncoderCheck::Axis(_)));
    "parameters-at-every-submodule" "Parameters are reached at each submodule of the encoder."
        "8.5 names the access point and does not say that no other submodule answers"
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::RecordAnswersAt(api, slot, _) => right || (api, slot) == (ENCODER_API, ENCODER_SLOT),
            _ => right,
        });
    "global-access-served" "Parameters are reached through record B02Fh as well."
        "11.2 names B02Eh and does not exclude the global access of PROFIdrive"
        => |d| d.checks.check(|check, right| right || check == EncoderCheck::IsParameterAccess(0xB02F));
};

static RECORDS_AND_MEMORY: &[Deviation] = permitted! {
    "wrong-parameters-refused" "A record with values that the hardware does not support is refused."
        "12.3, 0x1002: whether the write itself is refused is not said"
        => |d| d.encoder.write_record(|view, access, octets| {
            refuse(access, octets, |user| {
                user.class_4 && user.scaling && !serves(user, &view.hardware)
                    || user.speed_unit > 3
                    || user.compatible && user.life_sign_failures == 0
            })
        });
    "reserved-bits-refused" "A record whose reserved bits or bytes are not 0 is refused."
        "11.4: 'set to 0' without a reaction"
        => |d| d.encoder.write_record(|_, access, octets| without_reserved(access, octets));
    "unused-scaling-checked" "Scaling values that no encoder has are an error even while scaling is off."
        "11.4: 'no functionality' does not say that they are not checked"
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::UserParametersAreRight(user, _) => right && (1..=0xFFFF_FFFF).contains(&user.units_per_revolution),
            _ => right,
        });
    "range-below-a-revolution-is-an-error" "A total range below the units of a revolution is a parametrization error."
        "12.3, 0x1002: 'not compatible' is not defined"
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::ScalingIsServed(user, _) => right && user.range >= user.units_per_revolution,
            _ => right,
        });
    "record-in-force-at-once" "A record that is written during data exchange takes effect."
        "11.4 describes the record for start-up only"
        => |d| d.checks.set(EncoderCheck::RecordInExchange, true);
    "preset-value-limited" "A preset value beyond the range is refused."
        "11.3 gives P65000 no limits"
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::PresetValue { value, range } => right && u64::from(value) < range,
            _ => right,
        });
    "presets-slow" "An offset is stored in twice the time, so a preset is answered later."
        "the manual is silent: 16.2 has no times"
        => |d| d.encoder.offset_takes(|_| Duration::from_millis(80));
    "saves-fast" "P971 saves in a tenth of the time."
        "the manual is silent: P971 has no times"
        => |d| d.encoder.preset_value_takes(|_| Duration::from_millis(20));
    "saves-slow" "P971 saves within three seconds."
        "the manual is silent: P971 has no times"
        => |d| d.encoder.preset_value_takes(|_| Duration::from_secs(3));
    "diagnosis-late" "A diagnosis is reported half a second after its fault."
        "the manual is silent: 12.2 has no times"
        => |d| {
            let mut since = None;
            d.encoder.diagnoses(move |view, all| {
                if all.is_empty() {
                    since = None;
                    return all;
                }
                let begin = *since.get_or_insert(view.now);
                if view.now < begin + Duration::from_millis(500) { Vec::new() } else { all }
            });
        };
};

static PAGES_AND_NAMES: &[Deviation] = permitted! {
    "site-in-the-biz-domain" "The home page links to www.lika.biz."
        "17: the text names www.lika.biz and www.lika.it"
        => |d| d.web.text(|text| text.replace("href=\"http://www.lika.it/\"", "href=\"http://www.lika.biz/\""));
    "tags-in-capitals" "The tags of the pages are in capital letters."
        "the manual is silent: 17 shows the pages in figures only"
        => |d| d.web.text(|text| text.replace("<html>", "<HTML>").replace("</html>", "</HTML>").replace("<head>", "<HEAD>"));
    "menu-on-every-page" "Each page has the menu with its protected section."
        "17: the menu is described for the home page, and its other pages are lost with the figures"
        => |d| d.web.page(|_, request, page| match request.path.as_str() {
            "/" => page,
            _ => with_text(page, |text| text.replace("</body>", MENU)),
        });
    "entry-with-prefix-accepted" "An entry with the prefix 0x is the number after it."
        "17.2: 'enter the value without the 0x prefix' without a reaction"
        => |d| d.web.entered(|entry| String::from(entry.strip_prefix("0x").unwrap_or(entry)));
    "other-words-for-a-stored-value" "The preset page reports a stored value in other words."
        "17.2: the text of the page is lost with Figure 93"
        => |d| d.web.text(|text| text.replace("The preset value is stored.", "Preset OK."));
    "im0-profile-of-the-standard-api" "I&M0 has the standard API 0 as its profile."
        "11.1 prints no value for PROFILE ID (API), and the glossary calls API 0 the standard API"
        => |d| d.stack.im0(|im0| im0.profile_id = 0);
    "order-code-of-a-special-version" "I&M0 has an order code that ends with /S001."
        "2: order codes that end with /Sxxx are special versions"
        => |d| d.stack.im0(|im0| special_version(&mut im0.order_id));
    "names-of-up-to-240-characters" "A name of up to 240 characters is accepted."
        "PROFINET permits 240; the limit of 7.4.5 is given to the user"
        => |d| d.stack.check(|check, right| match check {
            StackCheck::Name(name) => right || accepts(name, 240),
            _ => right,
        });
};

fn status_in_effect(view: &EncoderView<'_>, settings: u64) -> u64 {
    let without_class_4 = if view.user.class_4 { 0 } else { 0x0D };
    let without_compatibility = if view.user.compatible { 0 } else { 0x10 };
    settings & !(without_class_4 | without_compatibility)
}

fn by_digits(number: u64) -> u64 {
    number / 10 * 16 + number % 10
}

fn with_type_codes(response: ParameterResponse) -> ParameterResponse {
    let values = response.values.into_iter().map(|value| match value.format {
        ParameterFormat::WORD => ParameterValue { format: ParameterFormat::UNSIGNED16, ..value },
        ParameterFormat::DOUBLE_WORD => ParameterValue { format: ParameterFormat::UNSIGNED32, ..value },
        _ => value,
    });
    ParameterResponse { values: values.collect(), ..response }
}

fn without_reserved(access: &RecordAccess, octets: RecordOctets) -> RecordOctets {
    let is_reserved = |octets: &Vec<u8>| {
        octets.first().is_some_and(|options| options & 0xC0 != 0) || octets.iter().skip(19).any(|octet| *octet != 0)
    };
    match octets {
        Ok(octets) if access.index == USER_PARAMETERS && is_reserved(&octets) => Err(RecordRefusal::InvalidParameter),
        other => other,
    }
}

/// Continues the order code with the suffix of a special version.
fn special_version(order_id: &mut [u8; 20]) {
    let end = order_id.iter().rposition(|octet| *octet != b' ').map_or(0, |last| last + 1);
    if let Some(suffix) = order_id.get_mut(end..end + 5) {
        suffix.copy_from_slice(b"/S001");
    }
}

/// The protected section of the menu.
const MENU: &str = "<p>Password protected menus: <a href=\"/upgrade.htm\">Firmware upgrade</a></p></body>";

/// Shows the version of the software as this number.
fn version(d: &mut Deviations, number: u64) {
    d.encoder.element(move |view, at, right| match at {
        (964 | 975, 2) if right == u64::from(view.facts.software[0]) => number,
        _ => right,
    });
}
