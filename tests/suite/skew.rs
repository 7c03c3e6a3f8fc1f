//! Skewed carry changes when, never what: every chunk size of every datapath against the plain form.

use std::rc::Rc;

use crate::noise::Noise;
use subdiv_rtl::cores::loop_fd::{self, Parameters, RegisterForm};
use subdiv_rtl::hdl::skew::{LEAD, SkewedPorts, skew};
use subdiv_rtl::hdl::{Builder, Flat, Integers, Module, Simulator, Word};

/// What comes out of a module in every clock, with the same noise at its inputs; single bits are seldom 1, and come
/// `lead` clocks before the numbers of their clock.
fn outputs(module: &Rc<Module>, seed: u64, clocks: usize, lead: usize) -> Vec<Vec<i128>> {
    let mut simulator = Simulator::new(Flat::new(module).unwrap(), Integers);
    let mut noise = Noise(seed);
    let words: Vec<Word> = module.inputs.iter().map(|&port| module.node(port).word).collect();
    let value = |word: &Word, noise: &mut Noise| match word.width() {
        1 => i128::from(noise.below(4) == 0),
        _ => word.range.wrap(noise.wide()),
    };
    let lines: Vec<Vec<i128>> =
        (0..clocks).map(|_| words.iter().map(|word| value(word, &mut noise)).collect()).collect();
    let inputs = simulator.flat.inputs.clone();
    let outputs = simulator.flat.outputs.clone();
    (0..clocks)
        .map(|clock| {
            for (port, (_, id)) in inputs.iter().enumerate() {
                let behind = if words[port].width() > 1 { lead } else { 0 };
                simulator.set(*id, lines[clock.saturating_sub(behind)][port]);
            }
            simulator.settle();
            let line = outputs.iter().map(|(_, id)| *simulator.get(*id)).collect();
            simulator.edge(false).unwrap();
            line
        })
        .collect()
}

/// Compares after a while in which what no reset has set is washed out.
fn same(plain: &Rc<Module>, chunk: u32, seed: u64) {
    let skewed = skew(plain, chunk, SkewedPorts::default()).unwrap();
    let late: Vec<usize> = plain
        .outputs
        .iter()
        .zip(&skewed.outputs)
        .map(|(p, s)| (skewed.latency(s) - plain.latency(p)) as usize)
        .collect();
    let a = outputs(plain, seed, 400, 0);
    let b = outputs(&skewed, seed, 400, LEAD as usize);
    for clock in 100..300 {
        for (port, &late) in late.iter().enumerate() {
            assert_eq!(
                a[clock][port],
                b[clock + late][port],
                "{} in chunks of {chunk}: {} in clock {clock}",
                plain.name,
                plain.outputs[port].name
            );
        }
    }
}

fn datapaths(parameters: Parameters) -> Vec<Rc<Module>> {
    let core = loop_fd::build(parameters).unwrap();
    let named = |name: &str| core.instances.iter().find(|i| i.name == name).unwrap().module.clone();
    vec![named("engine_x"), named("startup")]
}

#[test]
fn engines_and_start_ups_of_every_form() {
    for (seed, registers) in RegisterForm::ALL.into_iter().enumerate() {
        let parameters = Parameters::new("Q4.4".parse().unwrap(), 4, 3, registers).unwrap();
        for module in datapaths(parameters) {
            [4, 8, 12, 16, 20, 64].into_iter().for_each(|chunk| same(&module, chunk, seed as u64));
        }
    }
}

#[test]
fn sums_of_any_terms_and_shifts_both_ways() {
    let mut noise = Noise(11);
    for case in 0..60 {
        let m = Builder::new("sums");
        let words = [Word::signed(13), Word::unsigned(9), Word::signed(5), Word::unsigned(1)];
        let inputs: Vec<_> = words.iter().enumerate().map(|(i, &w)| m.input(format!("i{i}"), w)).collect();
        let mut coefficient = || noise.below(41) as i128 - 20;
        let [a, b, c, d] = [(); 4].map(|()| coefficient());
        let sum = m.pipe("sum", a * &inputs[0] + b * &inputs[1] + c * &inputs[2] + d);
        let down = m.round(&sum, 1 + case % 7, subdiv_rtl::fixed::Rounding::HalfUp);
        let chosen = m.select(&inputs[3], m.rescale(&down, 0), m.delay(&inputs[0], 1));
        let total = m.register_at("total", Word::modular(23), None, 1);
        m.on(&m.delay(&inputs[3], 1), &total, m.modulo(m.constant(5, Word::signed(4)), 23));
        m.always(&total, &total + &m.modulo(m.delay(&inputs[0], 1), 23));
        m.output("chosen", m.pipe("chosen", &chosen));
        m.output("total", m.pipe("total_out", 3 * &total));
        let module = m.finish().unwrap();
        [2, 3, 5, 7, 30].into_iter().for_each(|chunk| same(&module, chunk, u64::from(case)));
    }
}

#[test]
fn a_lost_carry_is_found() {
    let m = Builder::new("adder");
    let [a, b] = ["a", "b"].map(|name| m.input(name, Word::signed(20)));
    m.output("y", m.pipe("y", &a + &b));
    let plain = m.finish().unwrap();
    let m = Builder::new("adder");
    let [a, b] = ["a", "b"].map(|name| m.input(name, Word::signed(20)));
    m.output("y", m.pipe("y", &a + &b - 1));
    let other = m.finish().unwrap();
    let [right, wrong] =
        [&plain, &other].map(|module| outputs(&skew(module, 8, SkewedPorts::default()).unwrap(), 1, 60, 0));
    assert_ne!(right, wrong);
}

#[test]
fn memories_are_refused() {
    let m = Builder::new("table");
    let address = m.input("address", Word::unsigned(3));
    let table = m.memory("table", 8, Word::signed(9), vec![]);
    m.output("y", table.read("y", &address, None));
    let error = skew(&m.finish().unwrap(), 4, SkewedPorts::default()).unwrap_err();
    assert!(error.to_string().contains("chunks"), "{error}");
}
