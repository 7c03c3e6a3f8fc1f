//! Triangles a second of the reference model: one thread, level 6, coordinates of 24 bits (Q12.12), from the
//! control mesh (positions and triangles, nothing prepared) to rounded positions of every patch.
//!
//! Also the oracle, and a sweep: design points a second, one thread, blob at level 5, error and cracks of each.
//!
//! `cargo bench --bench model`; the `thrpt` line of each run counts triangles, or design points.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use subdiv_rtl::fixed::{Format, Fractions, Precision, Reduced, Rounding};
use subdiv_rtl::mesh::{quantise, shape};
use subdiv_rtl::model::loop_fd::LoopFd;
use subdiv_rtl::model::render::render;
use subdiv_rtl::model::sweep::Prepared;
use subdiv_rtl::surface::control_mesh::ControlMesh;
use subdiv_rtl::surface::fine_grid::FineGrid;
use subdiv_rtl::surface::limit_oracle::LimitOracle;
use subdiv_rtl::surface::table::Table;

const WIDTH: u32 = 24;
const LEVEL: u32 = 6;

/// The built-in shapes at Q12.12.
fn meshes() -> [(&'static str, ControlMesh); 2] {
    let control = |name: &str| {
        let mesh = shape(name).expect("a built-in shape");
        let format = Format { integer: 12, fraction: 12 };
        let positions = quantise(&mesh, format).expect("shapes lie within [-1, 1]").positions;
        ControlMesh::new(positions, mesh.triangles().expect("a triangle mesh")).expect("a manifold")
    };
    [("torus, 144 triangles", control("torus")), ("blob, 130 triangles, valences 3 to 9", control("blob"))]
}

fn reference_model(c: &mut Criterion) {
    let core = LoopFd::new(WIDTH, 0, LEVEL).expect("24 bits and level 6 are in range");
    let table = Table::for_width(WIDTH).expect("24 bits are in range");
    let mut group = c.benchmark_group("reference model, level 6");
    for (name, mesh) in meshes() {
        let triangles = FineGrid::new(&mesh, LEVEL).expect("level 6 can be numbered").triangle_count();
        group.throughput(Throughput::Elements(triangles as u64));
        let mut vertices = Vec::new();
        group.bench_function(name, |b| {
            b.iter(|| {
                let (positions, triangles) = (mesh.positions().to_vec(), mesh.triangles().to_vec());
                let mesh = ControlMesh::new(positions, triangles).expect("it was a mesh before");
                let counts = render(black_box(&mesh), LEVEL, &core, &table, &mut vertices);
                black_box((&vertices, counts.is_ok()));
            })
        });
    }
}

fn oracle(c: &mut Criterion) {
    let mut group = c.benchmark_group("limit oracle, level 6");
    group.sample_size(10);
    for (name, mesh) in meshes() {
        group.bench_function(name, |b| b.iter(|| LimitOracle::new(black_box(&mesh), LEVEL).is_ok()));
    }
}

/// Formats of a sweep at level 5: uniform and progressive, every rounding mode.
fn formats() -> Vec<Precision> {
    let texts = ["17", "20", "8,12,14,17,18", "7,11,15,18,18"];
    let fractions = texts.into_iter().filter_map(|text| text.parse::<Fractions>().ok());
    fractions
        .flat_map(|fractions| {
            Rounding::TOTAL.map(|rounding| Reduced { fractions, rounding, saturate: false })
        })
        .map(Precision::Reduced)
        .collect()
}

fn sweep(c: &mut Criterion) {
    let table = Table::for_width(WIDTH).expect("24 bits are in range");
    let mut group = c.benchmark_group("sweep, level 5");
    for (name, mesh) in meshes() {
        let prepared = Prepared::new(&mesh, 5, &table).expect("level 5 is in range");
        let (formats, mut vertices) = (formats(), vec![]);
        group.throughput(Throughput::Elements(formats.len() as u64));
        group.bench_function(name, |b| {
            b.iter(|| {
                for &format in &formats {
                    black_box(prepared.measure(WIDTH, 0, format, &mut vertices).is_ok());
                }
            })
        });
    }
}

criterion_group!(benches, reference_model, oracle, sweep);
criterion_main!(benches);
