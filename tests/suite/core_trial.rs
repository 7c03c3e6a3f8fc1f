//! A `loop-fd` against the reference: hard packets under stalls, bit for bit, in as many clocks as predicted.

use std::rc::Rc;

use subdiv_rtl::cores::loop_fd::{Parameters, build};
use subdiv_rtl::cosim::loop_bench::device;
use subdiv_rtl::cosim::loop_trial::LoopTrial;
use subdiv_rtl::cosim::{Builtin, External, Model, Settings, Simulator, Stall, Stimulus, Tool};
use subdiv_rtl::hdl::{Module, verilog};

/// Nothing stalls, both sides do, only the consumer does.
const STALLS: [(Stall, Stall); 3] = [
    (Stall::None, Stall::None),
    (Stall::Bursts, Stall::Random { percent: 40 }),
    (Stall::None, Stall::Bursts),
];

fn check(
    parameters: Parameters,
    stalls: &[(Stall, Stall)],
    simulator: &dyn Fn(&Rc<Module>) -> Box<dyn Simulator>,
) {
    let core = build(parameters).unwrap();
    let files = verilog::print(&core, "subdiv-rtl generate loop-fd").unwrap();
    let dut = device(&core, &files);
    for (seed, (gaps, back_pressure)) in stalls.iter().copied().enumerate() {
        let trial = LoopTrial::random(&core, parameters, seed as u64 + 1).unwrap();
        let stimulus = Stimulus::new(trial.input.clone(), trial.expected.clone());
        let mut stimulus = Stimulus { gaps, back_pressure, seed: 3, ..stimulus };
        stimulus.expected_clocks = Some(trial.clocks(&core, &stimulus).total);
        let outcome = simulator(&core).run(&dut, &stimulus).unwrap();
        assert_eq!(outcome.failures, [], "{parameters:?}, {gaps}, {back_pressure}");
        assert!(outcome.beats > 0);
    }
}

/// All of them in the simulator that needs no tools.
pub fn built_in(cores: Vec<Parameters>) {
    for parameters in cores {
        check(parameters, &STALLS, &|core| {
            let core = core.clone();
            Box::new(Builtin::new(move || Model::new(&core)))
        });
    }
}

/// All of them in the simulators that are here.
pub fn installed(cores: Vec<Parameters>) {
    for tool in [Tool::Verilator, Tool::Icarus] {
        // Short runs of many cores: what takes the time is to build them.
        let settings = Settings { compile_fast: true, ..Settings::default() };
        if let Err(error) = External::new(tool, settings.clone()).version() {
            println!("skipped: {error}");
            continue;
        }
        for &parameters in &cores {
            // Icarus is slow: both sides stall there.
            let stalls = if matches!(tool, Tool::Icarus) { &STALLS[1..2] } else { &STALLS[..] };
            check(parameters, stalls, &|_| Box::new(External::new(tool, settings.clone())));
        }
    }
}
