//! Hard strips for `cc-strip`: coordinates over the whole range, every valence beside every other, strips of
//! different levels one behind the other, and strips that must be dropped whole. No mesh sends these; a core must
//! stand them all the same.
//!
//! ```text
//! level 2, level 3, level 0, level 1, level 7, ...      in
//! columns of the good ones                              out, in the clocks that the protocol says
//! ```

use subdiv_rtl::cores::cc_strip::finish::{Kind, Normals};
use subdiv_rtl::cores::cc_strip::{Parameters, Precision, Schedule, build};
use subdiv_rtl::cosim::strip_bench::{protocol, reference_parameters, traffic, words};
use subdiv_rtl::cosim::strip_lanes::Lanes;
use subdiv_rtl::cosim::{Beat, Builtin, Model, Simulator, Stall, Stimulus, device};
use subdiv_rtl::fixed::{Format, Rounding};
use subdiv_rtl::model::cc_strip::CcStrip;
use subdiv_rtl::model::cc_strip_clocks;
use subdiv_rtl::surface::catmull_clark::strips::records::{Column, Guard, Outside, StripRecords};

type Point = [i64; 3];

/// Marsaglia's xorshift.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    /// One of the ends of the range as often as anything between.
    fn coordinate(&mut self, width: u32) -> i64 {
        let least = -(1i64 << (width - 1));
        match self.below(4) {
            0 => least,
            1 => -least - 1,
            _ => least + (self.next() >> (64 - width)) as i64,
        }
    }

    fn point(&mut self, width: u32) -> Point {
        [0; 3].map(|_| self.coordinate(width))
    }

    fn outside(&mut self, width: u32, least: u32, max_valence: u32) -> Outside<Point> {
        let valence = least + self.below(u64::from(max_valence + 1 - least)) as u32;
        let fan: Vec<Point> = (0..(2 * valence).saturating_sub(7)).map(|_| self.point(width)).collect();
        let [left, right] = match (fan.first(), fan.last()) {
            (Some(first), Some(last)) => [*first, *last],
            _ => [self.point(width), self.point(width)],
        };
        Outside { valence, fan, left, right, gap: None }
    }

    fn strip(&mut self, width: u32, max_valence: u32) -> StripRecords<Point> {
        let quads = 1 + self.below(4) as usize;
        // Valence 3 in every other column, the top and the bottom by turns.
        let column = |r: &mut Random, c: usize| Column {
            vertices: [r.point(width), r.point(width)],
            outside: [0, 1].map(|end| r.outside(width, if c % 2 == end { 3 } else { 4 }, max_valence)),
        };
        let guard = |r: &mut Random| {
            Some(Guard {
                vertices: [r.point(width), r.point(width)],
                outside: [r.point(width), r.point(width)],
            })
        };
        let guards = [guard(self), guard(self)];
        let columns = (0..=quads).map(|c| column(self, c)).collect();
        let mut strip = StripRecords { closed: false, columns, guards };
        (0..=quads).for_each(|c| close(&mut strip, c));
        strip
    }
}

/// Around a vertex of valence 3 lies one outside face: its neighbours in the strip are the outside vertices there, and
/// the columns beside it see the same fourth corner.
fn close(strip: &mut StripRecords<Point>, c: usize) {
    for end in 0..2 {
        if strip.columns[c].outside[end].valence != 3 {
            continue;
        }
        let guard = |side: usize| strip.guards[side].as_ref().unwrap();
        let (before, corner) = match c.checked_sub(1).map(|p| &strip.columns[p]) {
            Some(column) => (column.vertices[end], column.outside[end].right),
            None => (guard(0).vertices[end], guard(0).outside[end]),
        };
        let after = strip.columns.get(c + 1).map_or(guard(1).vertices[end], |column| column.vertices[end]);
        let outside = &mut strip.columns[c].outside[end];
        (outside.left, outside.right) = (after, before);
        match strip.columns.get_mut(c + 1).map(|column| &mut column.outside[end]) {
            Some(next) => {
                next.left = corner;
                next.fan[0] = corner;
                next.right = next.fan[next.fan.len() - 1];
            }
            None => strip.guards[1].as_mut().unwrap().outside[end] = corner,
        }
    }
}

fn try_hard(parameters: Parameters, seed: u64, stalls: [&str; 2]) {
    let what = format!("{parameters:?} seed {seed} {stalls:?}");
    let core = build(parameters).unwrap();
    let dut = device(&core, &[], None);
    let reference = CcStrip::new(reference_parameters(parameters)).unwrap();
    let mut random = Random(seed * 0x9e37_79b9 + 1);
    let (mut input, mut expected, mut strips): (Vec<Beat>, Vec<Beat>, Vec<_>) = (vec![], vec![], vec![]);
    for turn in 0..24 {
        // Every fourth strip is of a level that the core has not.
        let bad = [0, 7].into_iter().find(|&level| turn % 4 == 2 && (turn % 8 == 2) == (level == 0));
        let bad = bad.filter(|&level| level == 0 || level > parameters.levels);
        let level = bad.unwrap_or(1 + random.below(u64::from(parameters.levels)) as u32);
        let strip = random.strip(parameters.coordinates.width(), parameters.max_valence);
        let sent = words(&dut.input, level, &strip).unwrap();
        strips.push(traffic(level, &sent));
        input.extend(sent);
        if bad.is_none() {
            let columns = reference.columns(level, &strip).unwrap();
            expected.extend(Lanes::new(parameters, level).beats(&dut.output, &columns));
        }
    }
    let [gaps, back_pressure] = stalls.map(|stall| stall.parse::<Stall>().unwrap());
    let mut stimulus = Stimulus { gaps, back_pressure, seed, ..Stimulus::new(input, expected) };
    if parameters.longitudinal.is_none() {
        let (offer, ready) = (stimulus.offer_pattern(), stimulus.ready_pattern());
        let clocks = cc_strip_clocks::run(protocol(&core, parameters), &strips, &offer, &ready);
        stimulus.expected_clocks = Some(clocks);
    }
    let outcome = Builtin::new(|| Model::new(&core)).run(&dut, &stimulus).unwrap();
    assert!(outcome.passed(), "{what}: {:?}", outcome.error(&|beat| format!("beat {beat}")));
}

fn cases() -> Vec<Parameters> {
    let exact = Parameters::exact(Format { integer: 3, fraction: 7 }, 3, 6);
    let rows = |rows| Parameters { rows_per_clock: Some(rows), ..exact };
    let normals = |kind, unit| Some(Normals { kind, point_fraction: 7, unit });
    vec![
        exact,
        Parameters { levels: 4, max_valence: 16, folded: true, ..exact },
        Parameters { levels: 1, max_valence: 4, ..exact },
        Parameters { schedule: Schedule::Shared, output_fraction: 4, ..exact },
        Parameters { schedule: Schedule::Double, output_fraction: 11, ..exact },
        Parameters { schedule: Schedule::Double, folded: true, precision: Precision::Guard(2), ..exact },
        rows(2),
        Parameters { schedule: Schedule::Shared, precision: Precision::Guard(3), ..rows(4) },
        Parameters { precision: Precision::Guard(3), rounding: Rounding::HalfEven, ..exact },
        Parameters { precision: Precision::Guard(1), rounding: Rounding::Floor, ..exact },
        Parameters { precision: Precision::Guard(2), rounding: Rounding::Truncate, folded: true, ..exact },
        Parameters { registered: true, levels: 4, max_valence: 9, ..exact },
        Parameters {
            registered: true,
            precision: Precision::Guard(3),
            rounding: Rounding::Truncate,
            ..exact
        },
        Parameters { registered: true, precision: Precision::Guard(4), rounding: Rounding::Floor, ..rows(2) },
        Parameters { registered: true, precision: Precision::Guard(3), max_valence: 9, levels: 4, ..rows(4) },
        Parameters { registered: true, output_fraction: 9, table_bits: 30, ..rows(4) },
        Parameters { registered: true, axes_in_turn: 2, max_valence: 7, ..rows(2) },
        Parameters {
            registered: true,
            axes_in_turn: 3,
            levels: 5,
            precision: Precision::Guard(4),
            rounding: Rounding::Floor,
            ..rows(2)
        },
        Parameters { registered: true, max_valence: 4, levels: 2, output_fraction: 5, ..exact },
        Parameters { limit: true, ..exact },
        Parameters { limit: true, output_fraction: 3, normals: normals(Kind::Faces, None), ..exact },
        Parameters { normals: normals(Kind::Limit, Some(12)), schedule: Schedule::Shared, ..exact },
        Parameters { longitudinal: Some(2), ..exact },
    ]
}

#[test]
fn hard_strips_without_stalls() {
    cases().into_iter().for_each(|parameters| try_hard(parameters, 1, ["none", "none"]));
}

#[test]
fn hard_strips_with_stalls() {
    for parameters in cases() {
        try_hard(parameters, 2, ["random:30", "random:50"]);
        try_hard(parameters, 3, ["bursts", "one-in-3"]);
    }
}
