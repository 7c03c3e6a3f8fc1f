//! Digits in series change when, never what: datapaths in digits of many sizes against the plain form.

use std::rc::Rc;

use crate::noise::Noise;
use subdiv_rtl::hdl::serial::serial;
use subdiv_rtl::hdl::skew::LEAD;
use subdiv_rtl::hdl::{Builder, Flat, Integers, Module, Signal, Simulator, Word};

/// The word that all numbers of a module are kept in.
const WIDTH: u32 = 40;

/// Numbers in, numbers out, one after the other: the plain module with one a clock.
fn plain(module: &Rc<Module>, words: &[Vec<i128>], held: &[i128]) -> Vec<Vec<i128>> {
    let mut simulator = Simulator::new(Flat::new(module).unwrap(), Integers);
    let inputs = simulator.flat.inputs.clone();
    let outputs = simulator.flat.outputs.clone();
    let depth = module.latency(&module.outputs[0]) as usize;
    let mut lines = vec![];
    for clock in 0..words.len() + depth {
        let at = clock.min(words.len() - 1);
        let values = words[at].iter().copied().chain([held[at]]);
        for ((_, id), value) in inputs.iter().zip(values) {
            let word = simulator.flat.node(*id).word;
            simulator.set(*id, word.range.wrap(value));
        }
        simulator.settle();
        lines.push(outputs.iter().map(|(_, id)| *simulator.get(*id)).collect::<Vec<_>>());
        simulator.edge(false).unwrap();
    }
    lines.split_off(depth)
}

/// The same through the module in digits, with so many idle clocks between two numbers.
fn in_digits(
    module: &Rc<Module>,
    digit: u32,
    words: &[Vec<i128>],
    held: &[i128],
    idle: &mut dyn FnMut() -> u64,
) -> Vec<Vec<i128>> {
    let count = WIDTH.div_ceil(digit);
    let mut simulator = Simulator::new(Flat::new(module).unwrap(), Integers);
    let id = |name: &str| simulator.flat.input(name).unwrap();
    let (first, numbers, level) =
        (id("first"), (0..3).map(|i| id(&format!("i{i}"))).collect::<Vec<_>>(), id("held"));
    let outputs = simulator.flat.outputs.clone();
    let depth = u64::from(module.latency(&module.outputs[0]));
    // The clock of the first digit's pulse of each number.
    let mut starts = vec![];
    let mut clock = 2;
    for _ in words {
        starts.push(clock);
        clock += u64::from(count) + idle();
    }
    let mask = (1i128 << digit) - 1;
    let mut found = vec![vec![0i128; outputs.len()]; words.len()];
    simulator.edge(true).unwrap();
    for clock in 1..clock + depth + u64::from(count) {
        simulator.set(first, i128::from(starts.contains(&clock)));
        for (index, &start) in starts.iter().enumerate() {
            let lead = u64::from(LEAD);
            if (start + lead..start + lead + u64::from(count)).contains(&clock) {
                let place = (clock - start - lead) as u32 * digit;
                for (&id, word) in numbers.iter().zip(&words[index]) {
                    simulator.set(id, word >> place & mask);
                }
                simulator.set(level, held[index]);
            }
        }
        simulator.settle();
        for (index, &start) in starts.iter().enumerate() {
            if (start + depth..start + depth + u64::from(count)).contains(&clock) {
                let place = (clock - start - depth) as u32 * digit;
                for ((_, id), number) in outputs.iter().zip(&mut found[index]) {
                    *number |= *simulator.get(*id) << place;
                }
            }
        }
        simulator.edge(false).unwrap();
    }
    found
}

#[test]
fn sums_shifts_constants_and_choices() {
    let mut noise = Noise(5);
    for case in 0..60 {
        let m = Builder::new("sums");
        let word = Word::modular(WIDTH);
        let i: Vec<Signal> = (0..3).map(|n| m.input(format!("i{n}"), word)).collect();
        let held = m.input("held", Word::unsigned(1));
        let mut coefficient = || noise.below(81) as i128 - 40;
        let sum = m.pipelined("sum", coefficient() * &i[0] + coefficient() * &i[1] + 1 * &i[2]);
        let other = m.pipelined("other", &i[1] - 2 * &i[2] + coefficient() * (1i128 << (case % 23)));
        let far = m.wire("far", &sum << (case % 31));
        let held = m.at_time(&held, far.time().unwrap_or(0));
        let chosen = m.select(&held, &far, &sum);
        let total = m.pipelined("total", &chosen - &other);
        m.output("total", &total);
        m.output("other", m.at_time(&other, total.time().unwrap()));
        let module = m.finish().unwrap();
        let words: Vec<Vec<i128>> =
            (0..9).map(|_| (0..3).map(|_| word.range.wrap(noise.wide())).collect()).collect();
        let held: Vec<i128> = (0..9).map(|_| noise.below(2) as i128).collect();
        let wanted = plain(&module, &words, &held);
        for digit in [2, 3, 5, 8, 15, 20, 39] {
            let serial = serial(&module, digit, WIDTH.div_ceil(digit), &["held"]).unwrap();
            let mut gaps = Noise(case.into());
            let found = in_digits(&serial, digit, &words, &held, &mut || gaps.below(3));
            for (index, (wanted, found)) in wanted.iter().zip(&found).enumerate() {
                let wrapped: Vec<i128> = found.iter().map(|&number| word.range.wrap(number)).collect();
                assert_eq!(wanted, &wrapped, "case {case}, number {index}, digits of {digit}");
            }
        }
    }
}

#[test]
fn what_no_digit_can_do_is_refused() {
    let m = Builder::new("product");
    let [a, b] = ["a", "b"].map(|name| m.input(name, Word::signed(8)));
    m.output("y", m.pipe("y", m.product(&a, &b)));
    let error = serial(&m.finish().unwrap(), 4, 4, &[]).unwrap_err();
    assert!(error.to_string().contains("in digits"), "{error}");
}
