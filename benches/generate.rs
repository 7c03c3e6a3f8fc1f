//! How long it takes to generate `loop-fd` at Q12.12, maximum level 8: the whole package in memory, without
//! and with the proof by linear forms.

use criterion::{Criterion, criterion_group, criterion_main};
use subdiv_rtl::cores::loop_fd::{Parameters, RegisterForm};
use subdiv_rtl::fixed::Format;
use subdiv_rtl::package::loop_fd::package;

fn generate(criterion: &mut Criterion) {
    let coordinates = Format { integer: 12, fraction: 12 };
    let parameters =
        Parameters::new(coordinates, 12, 8, RegisterForm::Minimal20).expect("a core that exists");
    let mut group = criterion.benchmark_group("generate loop-fd, level 8");
    group.sample_size(10);
    for (name, prove) in [("without the proof", false), ("with the proof", true)] {
        group.bench_function(name, |b| b.iter(|| package(parameters, prove).expect("a core that is right")));
    }
    group.finish();
}

criterion_group!(benches, generate);
criterion_main!(benches);
