//! Compares what came out with what should have, bit for bit where `tkeep` says that it counts.

use super::beat::bit;
use super::failure::{Failure, Number, Shift};
use super::vectors::hex;
use super::{Beat, Port};
use num_bigint::{BigInt, BigUint, Sign};

/// The number of beats that differ, are missing or are too many, and the first difference.
pub(super) fn compare(port: &Port, expected: &[Beat], received: &[(u64, Beat)]) -> (u64, Option<Failure>) {
    let differs = |&(at, (_, got)): &(usize, &(u64, Beat))| {
        expected.get(at).is_none_or(|expected| !same(port, expected, got))
    };
    let missing = expected.len().saturating_sub(received.len());
    let different = received.iter().enumerate().filter(differs).count();
    let first = received.iter().take(expected.len()).enumerate().find(differs);
    let failure = first.map(|(at, (clock, got))| {
        let (signal, expected_number, got_number) = difference(port, &expected[at], got);
        Failure::Value {
            beat: at as u64,
            clock: *clock,
            signal,
            expected: expected_number,
            got: got_number,
            shift: shift(port, expected, received, at),
        }
    });
    ((different + missing) as u64, failure)
}

/// Equal in `tlast`, `tuser`, `tkeep` and in every bit of `tdata` that the expected beat keeps.
pub(super) fn same(port: &Port, expected: &Beat, got: &Beat) -> bool {
    expected == got
        || (expected.last == got.last
            && expected.user == got.user
            && expected.keep == got.keep
            && port.keep
            && (0..port.data)
                .all(|at| !port.kept(expected, at) || bit(&expected.data, at) == bit(&got.data, at)))
}

/// The first lane, else the first byte, else the signal that differs; both its numbers.
fn difference(port: &Port, expected: &Beat, got: &Beat) -> (String, Number, Number) {
    let differs = |lsb: u32, width: u32| {
        (lsb..lsb + width).any(|at| port.kept(expected, at) && bit(&expected.data, at) != bit(&got.data, at))
    };
    if let Some(lane) = port.lanes.iter().find(|lane| differs(lane.lsb, lane.width)) {
        let number = |beat: &Beat| Number::signed(&beat.data, lane.lsb, lane.width);
        return (lane.name.clone(), number(expected), number(got));
    }
    for lsb in (0..port.data).step_by(8) {
        let width = 8.min(port.data - lsb);
        if differs(lsb, width) {
            let number = |beat: &Beat| Number::unsigned(&beat.data, lsb, width);
            let name = format!("tdata[{}:{lsb}]", lsb + width - 1);
            return (name, number(expected), number(got));
        }
    }
    if expected.last != got.last {
        let number = |beat: &Beat| Number::unsigned(&[u64::from(beat.last)], 0, 1);
        ("tlast".into(), number(expected), number(got))
    } else if expected.user != got.user {
        let number = |beat: &Beat| Number::unsigned(&[beat.user], 0, port.user);
        ("tuser".into(), number(expected), number(got))
    } else {
        let number = |beat: &Beat| Number::unsigned(&beat.keep, 0, port.keep_bits());
        ("tkeep".into(), number(expected), number(got))
    }
}

/// Whether the beats from the first wrong one on fit when one is left out or put in.
fn shift(port: &Port, expected: &[Beat], received: &[(u64, Beat)], at: usize) -> Option<Shift> {
    // Two beats must fit (three are looked at) before it is called a shift and no accident.
    const FIT: usize = 3;
    let fits = |from: usize, to: usize| {
        let received = received.get(from..).unwrap_or_default();
        let expected = expected.get(to..).unwrap_or_default();
        let pairs = || expected.iter().zip(received).take(FIT);
        pairs().count() > 1 && pairs().all(|(expected, (_, got))| same(port, expected, got))
    };
    if fits(at, at + 1) {
        return Some(Shift::Lost);
    }
    let again = at > 0 && same(port, &expected[at - 1], &received[at].1);
    (again && fits(at + 1, at)).then_some(Shift::Repeated)
}

impl Number {
    fn unsigned(words: &[u64], lsb: u32, width: u32) -> Number {
        let digits = hex(words, lsb, width);
        let value = BigUint::parse_bytes(digits.as_bytes(), 16).unwrap_or_default();
        Number { hex: digits, value: BigInt::from_biguint(Sign::Plus, value) }
    }
    /// Two's complement.
    fn signed(words: &[u64], lsb: u32, width: u32) -> Number {
        let Number { hex, value } = Number::unsigned(words, lsb, width);
        let negative = bit(words, lsb + width - 1);
        let value = if negative { value - (BigInt::from(1) << width) } else { value };
        Number { hex, value }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn port() -> Port {
        Port::of_lanes([("left.x", 20), ("left.y", 20)]).with_keep().with_user(2).with_last()
    }
    fn counted(port: &Port, numbers: impl IntoIterator<Item = i128>) -> Vec<Beat> {
        numbers.into_iter().map(|number| port.beat_of(&[number, -number])).collect()
    }
    fn clocked(beats: Vec<Beat>) -> Vec<(u64, Beat)> {
        beats.into_iter().enumerate().map(|(at, beat)| (100 + at as u64, beat)).collect()
    }

    #[test]
    fn a_wrong_bit_is_named_by_lane_number_and_clock() {
        let port = port();
        let expected = counted(&port, 0..10);
        let mut got = expected.clone();
        got[6].data[0] ^= 1 << 24;
        let (count, failure) = compare(&port, &expected, &clocked(got));
        assert_eq!(count, 1);
        assert_eq!(
            failure.unwrap().describe(&|beat| format!("patch {}", beat / 4)),
            "beat 6 (patch 1), left.y: expected 0xfffffa (-6), got 0xfffffb (-5), clock 106"
        );
    }

    #[test]
    fn bytes_not_kept_do_not_count_and_kept_ones_do() {
        let port = port();
        let mut expected = counted(&port, 3..4);
        port.drop_lane(&mut expected[0], 1);
        let mut got = expected.clone();
        got[0].data[0] ^= 0xff << 24;
        assert_eq!(compare(&port, &expected, &clocked(got.clone())), (0, None));
        got[0].data[0] ^= 1;
        assert_eq!(compare(&port, &expected, &clocked(got)).0, 1);
    }

    #[test]
    fn signals_beside_the_data_are_compared() {
        let port = port();
        let expected = counted(&port, 0..1);
        let right = &expected[0];
        let wrong = [
            ("tlast", Beat { last: true, ..right.clone() }),
            ("tuser", Beat { user: 2, ..right.clone() }),
            ("tkeep", Beat { keep: vec![0], ..right.clone() }),
        ];
        for (name, got) in wrong {
            let (_, failure) = compare(&port, &expected, &clocked(vec![got]));
            let failure = failure.unwrap().to_string();
            assert!(failure.contains(name), "{failure}");
        }
    }

    #[test]
    fn lost_and_repeated_beats_are_recognized() {
        let port = port();
        let expected = counted(&port, 0..10);
        let lost = counted(&port, (0..10).filter(|&at| at != 4));
        let twice = counted(&port, [0, 1, 2, 3, 4, 4, 5, 6, 7, 8, 9]);
        let words = |got| compare(&port, &expected, &clocked(got)).1.unwrap().to_string();
        assert!(words(lost).starts_with("beat 4, left.x") && words(twice).starts_with("beat 5"));
        assert!(words(counted(&port, (0..10).filter(|&at| at != 4))).ends_with("was lost here"));
        assert!(words(counted(&port, [0, 1, 2, 2, 3, 4, 5])).ends_with("came twice"));
    }

    #[test]
    fn missing_beats_count_as_mismatches() {
        let port = port();
        let expected = counted(&port, 0..10);
        assert_eq!(compare(&port, &expected, &clocked(expected[..7].to_vec())), (3, None));
    }

    #[test]
    fn a_byte_outside_of_all_lanes_is_named_by_its_bits() {
        let port = Port { data: 24, ..Port::of_lanes([("x", 8)]) };
        let (expected, mut got) = (vec![port.beat()], vec![port.beat()]);
        got[0].data[0] = 0x80_0000;
        let failure = compare(&port, &expected, &clocked(got)).1.unwrap().to_string();
        assert!(failure.starts_with("beat 0, tdata[23:16]: expected 0x00 (0), got 0x80 (128)"));
    }
}
