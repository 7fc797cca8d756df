//! Cyclic data of a PROFINET device.

use super::loss::{LosesInputs, LosesOutputs};
use super::state::{FirstFrameWaits, LateOutputs};
use crate::needs::Need;
use crate::seams::late::{FrameTopic, Jitter};
use crate::tables::Group;
use core::time::Duration;
use wire::profinet::rt::{Instance, IoxS};

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        // The others cannot tell a lost frame from one that repeats the outputs before.
        needs: &[Need::WatchedController, Need::Profinet],
        deviations: permitted! {
            "output-frames-lost" "Now and then up to two cyclic frames with the outputs of the frame before do not arrive."
                "IEC 61158-6-10, DataHoldFactor: the consumer uses the last data until the data hold time expires"
                => |d| d.stack.add(LosesOutputs::row_of(2, 19));
        },
    },
    Group {
        needs: &[Need::Profinet],
        deviations: permitted! {
            "cycle-counter-starts-high" "The cycle counter starts shortly before its overflow."
                "IEC 61158-6-10, CycleCounter: the provider starts with any value"
                => |d| d.stack.inputs(|frame| shift_counter(frame, 0xFF00));
            "cycle-counter-in-the-middle" "The cycle counter starts at 0x4000."
                "IEC 61158-6-10, CycleCounter: the provider starts with any value"
                => |d| d.stack.inputs(|frame| shift_counter(frame, 0x4000));
            "inputs-one-cycle-old" "The inputs of a frame are one cycle old: the stack copies them at its own tick."
                "IEC 61158-6-10 is silent about the age of inputs; the application and the provider run independently"
                => |d| d.late.inputs(1);
            "inputs-two-cycles-old" "The inputs of a frame are two cycles old."
                "IEC 61158-6-10 is silent about the age of inputs; the application and the provider run independently"
                => |d| d.late.inputs(2);
            "outputs-one-cycle-late" "The outputs of a frame reach the application with the next frame."
                "IEC 61158-6-10 is silent about the time from a frame to the application; both run independently"
                => |d| d.stack.add(LateOutputs::default());
            "outputs-taken-late" "A frame with outputs is processed 0.4 ms after it has arrived."
                "IEC 61158-6-10 is silent about the time from a frame to the application"
                => |d| d.late.received(|topic| (topic == FrameTopic::Cyclic).then_some(Duration::from_micros(400)));
            "sends-late-in-the-cycle" "Cyclic frames leave 0.6 ms after the start of the cycle."
                "IEC 61158-6-10, FrameSendOffset 0xFFFFFFFF: at any time of the cycle"
                => |d| d.late.sent(|topic| (topic == FrameTopic::Cyclic).then_some(Duration::from_micros(600)));
            "sends-with-jitter" "Cyclic frames leave up to 0.4 ms after the start of the cycle, each at another time."
                "IEC 61158-6-10, RT_CLASS_1: the time within the cycle is not bound, only the data hold time is"
                => |d| {
                    let mut times = Jitter::new(5);
                    d.late.sent(move |topic| (topic == FrameTopic::Cyclic).then(|| times.next(Duration::from_micros(400))));
                };
        "first-frame-waits" "No cyclic frame is sent before ApplicationReady, except after a third of the data hold time."
                "IEC 61158-6-10: the first frame has to arrive within the data hold time after Connect"
                => |d| d.stack.add(FirstFrameWaits::default());
            "hold-time-checked-late" "The data hold time is checked at the next cycle after it has expired."
                "IEC 61158-6-10, DataHoldFactor: the consumer counts whole cycles of its own clock"
                => |d| d.stack.data_hold_time(|agreed| agreed + agreed / 8);
            "input-frames-lost" "Now and then one cyclic frame of the device does not arrive."
                "IEC 61158-6-10, DataHoldFactor: the consumer uses the last data until the data hold time expires"
                => |d| d.stack.add(LosesInputs::row_of(1, 23));
            "input-frames-lost-in-a-row" "Now and then up to four cyclic frames of the device do not arrive, fewer than the data hold factor."
                "IEC 61158-6-10, DataHoldFactor: the consumer uses the last data until the data hold time expires"
                => |d| d.stack.add(LosesInputs::row_of(4, 57));
            "bad-status-of-the-device" "Bad IOPS and IOCS say that the device has detected the problem."
                "IEC 61158-6-10, IOxS.Instance: detected by subslot, slot, IO device or IO controller"
                => |d| d.stack.status(|status| if status.is_good() { status } else { IoxS::bad(Instance::Device) });
            "bad-status-of-the-slot" "Bad IOPS and IOCS say that the slot has detected the problem."
                "IEC 61158-6-10, IOxS.Instance: detected by subslot, slot, IO device or IO controller"
                => |d| d.stack.status(|status| if status.is_good() { status } else { IoxS::bad(Instance::Slot) });
        },
    },
];

/// Adds `start` to the cycle counter of a cyclic frame, which is in front of DataStatus and TransferStatus.
fn shift_counter(frame: &mut [u8], start: u16) {
    let Some(at) = frame.len().checked_sub(4) else { return };
    let counter = u16::from_be_bytes([frame[at], frame[at + 1]]).wrapping_add(start);
    frame[at..at + 2].copy_from_slice(&counter.to_be_bytes());
}
