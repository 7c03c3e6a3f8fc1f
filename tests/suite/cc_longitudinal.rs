//! Row-major output: the buffer in the built-in simulator against the order of the reference, under stalls on both
//! sides, for strips of every length and for levels that change from strip to strip; its clocks; its Verilog.

use crate::noise::Noise;
use subdiv_rtl::cores::cc_strip::longitudinal::build;
use subdiv_rtl::hdl::{Flat, Integers, NodeId, Simulator, Word};
use subdiv_rtl::model::cc_strip::longitudinal::{Sent, clocks, rows_of};

type Point = [i128; 3];

/// A fine strip; every column has the rows of its level.
type Strip = Vec<Vec<Point>>;

const AXES: [&str; 3] = ["x", "y", "z"];

struct Bench {
    simulator: Simulator<Integers>,
    rows: usize,
}

/// The outputs in one clock.
#[derive(Clone, Debug, PartialEq)]
struct Seen {
    column_ready: bool,
    vertex: Option<Sent<Point>>,
}

impl Bench {
    fn new(log_columns: u32, levels: u32, word: Word) -> Bench {
        let module = build(log_columns, levels, word).unwrap();
        let mut simulator = Simulator::new(Flat::new(&module).unwrap(), Integers);
        simulator.scramble(7);
        simulator.settle();
        let mut bench = Bench { simulator, rows: 1 + (1 << levels) };
        bench.put("column_valid", 0);
        bench.put("ready", 0);
        bench.simulator.settle();
        bench.simulator.edge(true).unwrap();
        bench
    }

    fn put(&mut self, name: &str, value: i128) {
        let id: NodeId = self.simulator.flat.input(name).unwrap_or_else(|| panic!("no input {name}"));
        self.simulator.set(id, value);
    }

    fn get(&self, name: &str) -> i128 {
        *self.simulator.get(self.simulator.flat.output(name).unwrap_or_else(|| panic!("no output {name}")))
    }

    fn clock(&mut self, column: Option<(&Vec<Point>, bool)>, ready: bool) -> Seen {
        self.put("column_valid", column.is_some().into());
        self.put("ready", ready.into());
        if let Some((column, last)) = column {
            self.put("column_last", last.into());
            self.put("last_row", column.len() as i128 - 1);
            for row in 0..self.rows {
                for (axis, name) in AXES.iter().enumerate() {
                    // Rows that are not in use hold anything.
                    self.put(&format!("row_{row}_{name}"), column.get(row).map_or(-1, |p| p[axis]));
                }
            }
        }
        self.simulator.settle();
        let vertex = (self.get("valid") != 0).then(|| Sent {
            vertex: AXES.map(|axis| self.get(axis)),
            row_end: self.get("row_end") != 0,
            chunk_end: self.get("chunk_end") != 0,
            strip_end: self.get("strip_end") != 0,
        });
        let seen = Seen { column_ready: self.get("column_ready") != 0, vertex };
        self.simulator.edge(false).unwrap();
        seen
    }

    /// All strips through the buffer; an offer is kept until it is taken. Returns what came, and the clocks from
    /// the first offer to the last vertex.
    fn run(
        &mut self,
        strips: &[Strip],
        mut offers: impl FnMut() -> bool,
        mut ready: impl FnMut() -> bool,
    ) -> (Vec<Sent<Point>>, u64) {
        let last = |strip: &Strip, i: usize| i + 1 == strip.len();
        let columns: Vec<(&Vec<Point>, bool)> =
            strips.iter().flat_map(|s| s.iter().enumerate().map(|(i, c)| (c, last(s, i)))).collect();
        let (mut next, mut offered, mut received) = (0, false, vec![]);
        let mut held: Option<Sent<Point>> = None;
        let (mut begun, mut ended) = (None, 0);
        for clock in 0u64.. {
            offered |= next < columns.len() && offers();
            begun = begun.or(offered.then_some(clock));
            let accepts = ready();
            let seen = self.clock(columns.get(next).copied().filter(|_| offered), accepts);
            if held.is_some() {
                assert_eq!(seen.vertex, held, "a vertex that was not taken changed at clock {clock}");
            }
            if offered && seen.column_ready {
                (next, offered, ended) = (next + 1, false, clock);
            }
            held = None;
            match seen.vertex {
                Some(vertex) if accepts => {
                    received.push(vertex);
                    ended = clock;
                }
                waiting => held = waiting,
            }
            if clock > ended + 500 {
                break;
            }
        }
        assert_eq!(next, columns.len(), "columns that were never taken");
        (received, ended + 1 - begun.unwrap_or(0))
    }
}

/// Strips of these lengths and levels, every vertex another one.
fn strips(shapes: &[(usize, u32)], noise: &mut Noise, word: Word) -> Vec<Strip> {
    let mut column = |levels: u32| -> Vec<Point> {
        (0..1 + (1 << levels)).map(|_| AXES.map(|_| word.range.wrap(noise.wide()))).collect()
    };
    shapes.iter().map(|&(columns, levels)| (0..columns).map(|_| column(levels)).collect()).collect()
}

#[test]
fn rows_come_in_the_order_of_the_reference_under_any_stalls() {
    let word = Word::signed(18);
    let mut noise = Noise(11);
    for (log_columns, levels) in [(1, 1), (2, 2), (3, 3), (4, 1), (2, 0)] {
        let longest = 1usize << log_columns;
        // Shorter and longer than a chunk, ending with a full one, a column too many; levels that change.
        let lengths = [2, longest, longest + 1, 2 * longest - 1, 2 * longest, 3 * longest + 2, 5, 1];
        let shapes: Vec<(usize, u32)> =
            lengths.iter().map(|&n| (n, noise.below(u64::from(levels) + 1) as u32)).collect();
        let strips = strips(&shapes, &mut noise, word);
        let expected: Vec<Sent<Point>> = strips.iter().flat_map(|s| rows_of(s, longest)).collect();
        for (gaps, stalls) in [(0, 0), (60, 0), (0, 60), (30, 30), (95, 10), (10, 95)] {
            let mut bench = Bench::new(log_columns, levels, word);
            let (mut left, mut right) = (Noise(noise.next()), Noise(noise.next()));
            let (received, _) = bench.run(&strips, || !left.percent(gaps), || !right.percent(stalls));
            let first = received.iter().zip(&expected).position(|(a, b)| a != b);
            assert_eq!(first, None, "N = {longest}, {levels} levels, stalls {gaps} and {stalls}: {shapes:?}");
            assert_eq!(received.len(), expected.len());
        }
    }
}

#[test]
fn a_vertex_leaves_in_every_clock_once_a_chunk_is_full() {
    let word = Word::signed(12);
    for (log_columns, levels, shapes) in [
        (3, 2, &[(50, 2)][..]),
        (2, 3, &[(13, 3), (13, 3), (4, 3)]),
        (3, 2, &[(3, 2), (20, 1), (9, 2), (2, 2)]),
        (1, 1, &[(9, 1)]),
    ] {
        let strips = strips(shapes, &mut Noise(5), word);
        let (received, measured) = Bench::new(log_columns, levels, word).run(&strips, || true, || true);
        let sizes: Vec<(usize, usize)> = shapes.iter().map(|&(columns, l)| (columns, 1 + (1 << l))).collect();
        assert_eq!(measured, clocks(&sizes, 1 << log_columns), "{shapes:?}");
        println!("N = {}, {shapes:?}: {} vertices in {measured} clocks", 1 << log_columns, received.len());
    }
}

#[test]
fn chunks_without_a_quad_are_refused() {
    for log_columns in [0, 13] {
        let error = build(log_columns, 2, Word::signed(12)).err().unwrap();
        assert_eq!(error.exit_status(), 2);
    }
}
