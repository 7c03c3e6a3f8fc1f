//! The rows of a window whose columns leave a row's cell a clock: in RAMs made of lookup tables, read in their order.
//!
//! ```text
//! rows 2 p, 2 p + 1 ──► even, odd of the bank of the next column      three banks: a column moves on by a new bank
//! slice p ──► row p + 2 of each bank ──► of each column ──► below ──► 1 ──► 0 ──► above
//! ```
//!
//! A choice among all rows would be wide and slow. The ends stay in registers, too: they are walked around.

use std::rc::Rc;

use super::Parameters;
use super::engine::Unit;
use super::window::STAGES;
use crate::error::Result;
use crate::hdl::{Builder, Module, Placed, Signal, Word};

/// The register that says which bank the next column is in.
pub const BANK: &str = "bank";

/// The banks: a column each.
pub const BANKS: u32 = 3;

/// The name of the RAM of the even or odd rows of a bank.
pub fn ram(parity: usize, bank: u32) -> String {
    format!("{}_rows_of_bank_{bank}", ["even", "odd"][parity])
}

/// The bank of a column of [`STAGES`] where the next one is in `next`.
pub fn bank_of(column: usize, next: u32) -> u32 {
    (next + 1 + column as u32) % BANKS
}

/// Inputs: `shift`, `comes` and `from`: a slice comes in, and which; its rows `row_0` and `row_1` a clock later, the `slice`
/// that leaves. Outputs: `.._read`, row `slice` + 2 of each column, where it is none of the last.
pub fn build(parameters: Parameters, level: u32) -> Result<Rc<Module>> {
    let m = Builder::new(&format!("row_reader_{level}"));
    m.purpose(format!("One coordinate of the rows of three columns of level {level}, in RAMs."));
    let word = parameters.word(level);
    let shift = m.input("shift", Word::bit());
    let half = 1u32 << (level - 1);
    let comes = m.input("comes", Word::bit());
    let from = m.input("from", Word::unsigned(level - 1));
    let rows = [0, 1].map(|u| m.input_at(format!("row_{u}"), word, 1));
    let slice = m.input("slice", Word::unsigned(level));

    let bank = m.register_reset(BANK, Word::range(0, i128::from(BANKS) - 1), 0);
    m.on(&(&shift & m.is(&bank, i128::from(BANKS) - 1)), &bank, m.constant(0, bank.word()));
    m.on(&shift, &bank, m.wrap(&bank + 1, bank.word()));

    let written = m.pipe("written", &from);
    // Two rows further than the slice: even and odd ones of the same number lie side by side.
    let half_word = Word::unsigned(level - 1);
    let asked = m.pipe("asked", m.wrap(&m.slice(&slice, 1, level - 1) + 1, half_word));
    let odd = m.at_time(&m.slice(&slice, 0, 1), 1);
    let of_bank: Vec<[Signal; 2]> = (0..BANKS)
        .map(|b| {
            // The first slice of a column goes to its bank.
            let before = (b + BANKS - 1) % BANKS;
            let next = m.select(&shift, m.is(&bank, before.into()), m.is(&bank, b.into()));
            [0, 1].map(|parity| {
                let name = ram(parity, b);
                let here = m.copy(format!("comes_to_{name}"), &comes & &next);
                let ram = m.memory(&name, half, word, vec![]).distributed();
                ram.write(&here, &written, &rows[parity]);
                ram.read(&format!("{name}_read"), &asked, None)
            })
        })
        .collect();
    for (column, stage) in STAGES.iter().enumerate() {
        let is =
            |next: u32| m.copy(format!("{stage}_of_next_{next}"), m.restart(&m.is(&bank, next.into()), 1));
        let odd = m.copy(format!("{stage}_is_odd"), &odd);
        let of = |next: u32| {
            let [even_row, odd_row] = &of_bank[bank_of(column, next) as usize];
            m.select(&odd, odd_row, even_row)
        };
        let row = m.select(&is(2), of(2), m.select(&is(1), of(1), of(0)));
        m.output(format!("{stage}_read"), m.pipe(format!("{stage}_read"), &row));
    }
    m.finish()
}

/// The reader of an engine, on the ports of its window and others of their kind.
pub fn place(m: &Builder, parameters: Parameters, level: u32, ports: &[(String, Signal)]) -> Result<Placed> {
    let unit = build(parameters, level)?;
    let mut inputs: Vec<(String, Signal)> = vec![];
    for id in &unit.inputs {
        let port = unit.node(*id);
        let name = port.name.clone().unwrap_or_default();
        let known = ports.iter().find(|(known, _)| *known == name).map(|(_, signal)| signal.clone());
        let signal =
            known.unwrap_or_else(|| m.input_at(format!("in_{name}"), port.word, port.time.unwrap_or(0)));
        inputs.push((name, signal));
    }
    let inputs: Vec<(&str, &Signal)> = inputs.iter().map(|(name, signal)| (name.as_str(), signal)).collect();
    Ok(m.instance("row_reader", &unit, &inputs))
}

impl Unit<'_> {
    /// The rows that the slice in turn sees of the three columns: above, 0, 1, below.
    pub(super) fn rows_read(&self, reader: &Placed) -> [Vec<Option<Signal>>; 3] {
        let (m, columns) = (self.m, &self.columns[0]);
        let slices = self.group.most_slices();
        let last = columns.rows() as i64 - 1;
        let time = reader.out(&format!("{}_read", STAGES[0])).time().unwrap_or(0);
        // The window stands.
        let stands = |signal: Signal| m.restart(&signal, time);
        let slice = m.concat(&self.slice.iter().rev().collect::<Vec<_>>());
        let [first, last_but_one, last_of_all] =
            [("first_slice", 0), ("last_slice_but_one", slices - 2), ("last_slice", slices - 1)]
                .map(|(name, number)| m.at_time(&m.pipe(name, m.is(&slice, number.into())), time - 1));
        [0, 1, 2].map(|column| {
            let stage = STAGES[column];
            let flag = |name: &str, flag: &Signal| m.copy(format!("{stage}_{name}"), flag);
            let read = reader.out(&format!("{stage}_read"));
            let mut below = m.select(
                &flag("last_but_one", &last_but_one),
                columns.row(column, last).map_or(read.clone(), stands),
                &read,
            );
            if let Some(outside) = columns.row(column, last + 1) {
                below = m.select(&flag("last", &last_of_all), stands(outside), &below);
            }
            let mut behind = m.pipe(format!("{stage}_below"), &below);
            let mut rows = vec![Some(behind.clone())];
            for (name, at) in [("1", 1), ("0", 0), ("above", -1)] {
                // What the slice before saw a row further down.
                let before = m.restart(&behind, time);
                let row = match columns.row(column, at) {
                    Some(first_row) => {
                        m.select(&flag(&format!("first_{name}"), &first), stands(first_row), &before)
                    }
                    None => before,
                };
                behind = m.pipe(format!("{stage}_{name}"), &row);
                rows.push(Some(behind.clone()));
            }
            rows.reverse();
            rows
        })
    }
}
