//! The running columns of one coordinate, each with a head that waits and a rounder.

use std::rc::Rc;

use super::super::Parameters;
use super::super::engine::{Columns, Higher};
use crate::cores::rounder::{self, Division, Rounder};
use crate::error::Result;
use crate::hdl::{Builder, Module, Signal, Word};

/// Inputs: at `take_k` the head of column k is `last_l`, at the last of them that of the column behind it `next_l`;
/// `strip` starts all columns from their heads, one lane's from those that are there now; `step` goes one row up;
/// `valid` says that the vertices of the row mean
/// something, `keep_k` that there is a vertex in column k. Outputs: `v0` ... , rounded. Buffered, there is column 0 alone.
pub fn build(parameters: Parameters, lanes: u32) -> Result<Rc<Module>> {
    let m = Builder::new("columns");
    m.purpose("Neighbouring columns of one coordinate, a vertex of each in a clock, and their rounding.");
    m.parameter("lanes", lanes);
    let takes = if lanes == 1 { 0 } else { lanes };
    let takes: Vec<Signal> = (0..takes).map(|k| m.input(format!("take_{k}"), Word::bit())).collect();
    let [strip, step, valid] = ["strip", "step", "valid"].map(|name| m.input(name, Word::bit()));
    let others = if parameters.is_buffered() { 0 } else { lanes };
    let keeps: Vec<Signal> = (1..=others).map(|k| m.input(format!("keep_{k}"), Word::bit())).collect();
    let word = |l| parameters.difference((0, l));
    let heads = |name: &str| [0, 1, 2, 3].map(|l| m.input(format!("{name}_{l}"), word(l)));
    let last = heads("last");
    let next = (others > 0).then(|| heads("next"));
    let fourth = m.input("fourth", parameters.difference((1, 3)));

    let held = |name: String, when: &Signal, of: &Signal| {
        let register = m.register(name, of.word());
        m.on(when, &register, of);
        register
    };
    let head_fourth = match takes.first() {
        Some(take) => held("head_fourth".into(), take, &fourth),
        None => fourth,
    };
    let fourth = held("fourth_now".into(), &strip, &head_fourth);
    let rounder = rounder::build(Rounder {
        modulus: parameters.modulus(),
        shift: parameters.shift(),
        result: parameters.output_range(),
        fraction: parameters.output_fraction,
        division: if parameters.digit().is_some() { Division::Digits } else { Division::Reciprocal },
        halved: true,
    })?;
    let running = Columns { m: &m, parameters, strip: &strip, step: &step };
    let mut vertices = vec![];
    for k in 0..=others as usize {
        let source = next.as_ref().filter(|_| k == lanes as usize).unwrap_or(&last);
        let head = match takes.get(k).or(takes.last()) {
            Some(take) => [0, 1, 2, 3].map(|l| held(format!("head_{k}_{l}"), take, &source[l])),
            None => source.clone(),
        };
        let numerator = running.column(&format!("column_{k}"), head, 0, Higher::twice(&fourth));
        let means = match k {
            0 => valid.clone(),
            _ => m.wire(format!("valid_{k}"), &valid & &keeps[k - 1]),
        };
        let placed =
            m.instance(&format!("round_{k}"), &rounder, &[("numerator", &numerator), ("valid", &means)]);
        vertices.push(placed.out("rounded"));
    }
    let depth = vertices.iter().filter_map(Signal::time).max().unwrap_or(0);
    for (k, vertex) in vertices.iter().enumerate() {
        m.output(format!("v{k}"), m.at_time(vertex, depth));
    }
    m.finish()
}
