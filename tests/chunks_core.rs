//! `loop-fd` in chunks with skewed carry: the same vertices as the reference for every chunk size and form, in every
//! simulator that is here, on hard packets under stalls, in as many clocks as predicted.

use subdiv_rtl::cores::loop_fd::{Parameters, RegisterForm, build};
use subdiv_rtl::cosim::loop_bench::device;
use subdiv_rtl::cosim::loop_trial::LoopTrial;
use subdiv_rtl::cosim::{Builtin, External, Model, Settings, Simulator, Stall, Stimulus, Tool};
use subdiv_rtl::fixed::{Precision, Reduced};
use subdiv_rtl::hdl::verilog;

const CHUNKS: [Option<u32>; 6] = [Some(4), Some(8), Some(12), Some(16), Some(20), None];

/// One core for each chunk size; all forms, some with one level only.
fn cores() -> Vec<Parameters> {
    let forms = RegisterForm::ALL.into_iter().cycle();
    let ranges = [(0, 3), (3, 3), (2, 4)].into_iter().cycle();
    let mut cores: Vec<Parameters> = CHUNKS
        .into_iter()
        .zip(forms)
        .zip(ranges)
        .map(|((chunk, form), (low, high))| {
            let exact = Parameters::new("Q4.4".parse().unwrap(), 5, high, form).unwrap();
            let exact = exact.with_min_level(low).unwrap();
            chunk.map_or(exact, |chunk| exact.with_chunk(chunk).unwrap())
        })
        .collect();
    let plain = Parameters::new("Q4.4".parse().unwrap(), 4, 3, RegisterForm::Minimal20).unwrap();
    let reduced = Precision::Reduced(Reduced::new("5,8,8,8,9".parse().unwrap()));
    cores.push(plain.with_precision(reduced).and_then(|p| p.with_chunk(7)).unwrap());
    cores
}

fn check(
    parameters: Parameters,
    simulator: &dyn Fn(&std::rc::Rc<subdiv_rtl::hdl::Module>) -> Box<dyn Simulator>,
) {
    let core = build(parameters).unwrap();
    let files = verilog::print(&core, "subdiv-rtl generate loop-fd").unwrap();
    let dut = device(&core, &files);
    let stalls = [
        (Stall::None, Stall::None),
        (Stall::Bursts, Stall::Random { percent: 40 }),
        (Stall::None, Stall::Bursts),
    ];
    for (seed, (gaps, back_pressure)) in stalls.into_iter().enumerate() {
        let trial = LoopTrial::random(&core, parameters, seed as u64 + 1).unwrap();
        let stimulus = Stimulus::new(trial.input.clone(), trial.expected.clone());
        let mut stimulus = Stimulus { gaps, back_pressure, seed: 3, ..stimulus };
        stimulus.expected_clocks = Some(trial.clocks(&core, &stimulus).total);
        let outcome = simulator(&core).run(&dut, &stimulus).unwrap();
        assert_eq!(outcome.failures, [], "{parameters:?}, {gaps}, {back_pressure}");
        assert!(outcome.beats > 0);
    }
}

#[test]
fn the_built_in_simulator_agrees() {
    for parameters in cores() {
        check(parameters, &|core| {
            let core = core.clone();
            Box::new(Builtin::new(move || Model::new(&core)))
        });
    }
}

#[test]
fn verilator_and_icarus_agree_too() {
    for tool in [Tool::Verilator, Tool::Icarus] {
        let settings = Settings::default();
        if let Err(error) = External::new(tool, settings.clone()).version() {
            println!("skipped: {error}");
            continue;
        }
        for parameters in cores() {
            check(parameters, &|_| Box::new(External::new(tool, settings.clone())));
        }
    }
}
