//! Design points a second, all cores: the blob of 130 triangles at level 5, without synthesis; meshes and oracle are
//! prepared within the measured time.
//!
//! `cargo bench --bench explore`; the `thrpt` line counts points.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use subdiv_rtl::cores::loop_fd::RegisterForm;
use subdiv_rtl::explore::axes::Axes;
use subdiv_rtl::explore::evaluate::Evaluator;
use subdiv_rtl::explore::meshes::Subject;
use subdiv_rtl::explore::point::{Origin, Precision};
use subdiv_rtl::explore::ranges::Numbers;
use subdiv_rtl::explore::run::{available_threads, run};
use subdiv_rtl::fixed::Rounding;

fn sweeps(criterion: &mut Criterion) {
    let blob = Subject::load(&Origin::Shape("blob".into()), false).expect("a built-in shape");
    let axes = |precisions: Vec<Precision>| Axes {
        scheme: None,
        levels: Numbers::from(5),
        coordinates: vec!["Q12.12".parse().expect("a format")],
        precisions,
        tables: None,
        roundings: Rounding::TOTAL.to_vec(),
        registers: vec![RegisterForm::Minimal20],
    };
    let progressive = (14..=19).flat_map(|f| (8..=10).map(move |e| [e, e + 4, f, f + 2, f + 3]));
    let mut group = criterion.benchmark_group("explore blob, level 5");
    group.sample_size(10);
    for (name, precisions) in [
        ("uniform, four roundings", (4..=24).map(Precision::Uniform).collect::<Vec<_>>()),
        ("progressive, four roundings", progressive.map(Precision::Progressive).collect()),
    ] {
        let sweep = axes(precisions).sweep(std::slice::from_ref(&blob)).expect("valid points");
        group.throughput(Throughput::Elements(sweep.points.len() as u64));
        group.bench_function(name, |b| {
            b.iter(|| {
                let evaluator = Evaluator::new(vec![blob.clone()], false);
                let records = run(&evaluator, &sweep.points, None, available_threads(), |_| {});
                assert!(records.expect("every point can be evaluated").iter().all(|r| r.within_bound()));
            })
        });
    }
    group.finish();
}

criterion_group!(benches, sweeps);
criterion_main!(benches);
