//! The estimate beside what was measured, and the measurement anew.

use std::path::Path;

use subdiv_rtl::cli::synth::subject;
use subdiv_rtl::cosim::Settings;
use subdiv_rtl::fpga::estimate::{Calibration, Constants, Features, Point};
use subdiv_rtl::fpga::{Device, Options, measure};

/// How far an estimate may lie from what was measured.
const ALLOWED: f64 = 0.15;

fn features(calibration: &Calibration) -> Vec<Features> {
    calibration
        .point
        .iter()
        .map(|point| Features::of(&subject(&point.core).unwrap().module).unwrap())
        .collect()
}

/// How far the estimates of LUTs, flip-flops and clock lie from a point.
fn errors(constants: &Constants, features: &Features, point: &Point) -> [f64; 3] {
    let made = constants.estimate(features, Device::named(&point.device).unwrap());
    let of = |estimate: f64, found: f64| estimate / found - 1.0;
    [
        of(made.luts as f64, point.luts as f64),
        of(made.flip_flops as f64, point.flip_flops as f64),
        of(made.clock_mhz, point.mhz),
    ]
}

/// A row for each point, and the largest error.
fn show(calibration: &Calibration, features: &[Features]) -> f64 {
    let mut largest = 0f64;
    println!("{:>6} {:>6} {:>6}  of LUT, FF, clock", "error", "error", "error");
    for (point, features) in calibration.point.iter().zip(features) {
        let device = Device::named(&point.device).unwrap();
        let errors = errors(calibration.constants(device.family).unwrap(), features, point);
        largest = errors.iter().fold(largest, |largest, error| largest.max(error.abs()));
        let errors = errors.map(|error| format!("{:+5.1}%", 100.0 * error)).join(" ");
        let Point { device, core, luts, flip_flops, mhz, .. } = point;
        println!("{errors}  {luts} {flip_flops} {mhz}  {core} on {device}");
    }
    largest
}

#[test]
fn every_estimate_lies_within_15_percent() {
    let calibration = Calibration::built_in().unwrap();
    assert!(calibration.point.len() >= 10);
    let largest = show(&calibration, &features(&calibration));
    assert!(largest <= ALLOWED, "{largest}");
}

/// Fits the constants and writes the file.
fn write(mut calibration: Calibration) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/fpga/estimate/calibration.toml");
    let features = features(&calibration);
    calibration.fit(&features);
    show(&calibration, &features);
    std::fs::write(file, calibration.text().unwrap()).unwrap();
}

/// Measures what the table names (what was measured before comes from the cache), fits, and writes the table.
#[test]
#[ignore = "places and routes for hours; writes src/fpga/estimate/calibration.toml"]
fn measured_anew() {
    let mut calibration = Calibration::built_in().unwrap();
    for point in &mut calibration.point {
        let options = Options {
            device: Device::named(&point.device).unwrap(),
            seeds: 1,
            target_mhz: point.target_mhz,
            cached: true,
            settings: Settings { timeout: std::time::Duration::from_secs(7200), ..Settings::default() },
        };
        println!("{} on {}", point.core, point.device);
        let report = measure(&subject(&point.core).unwrap(), &options, &|_, _| ()).unwrap();
        point.luts = report.area.luts;
        point.flip_flops = report.area.flip_flops;
        point.mhz = report.clock.median;
    }
    write(calibration);
}

/// What is counted in a core: SUBJECT names it.
#[test]
#[ignore = "prints"]
fn counted() {
    let core = std::env::var("SUBJECT").unwrap();
    let started = std::time::Instant::now();
    let features = Features::of(&subject(&core).unwrap().module).unwrap();
    println!("{features:#?} {:?}", started.elapsed());
}

/// Only fits to what stands in the table, as after the counts have changed.
#[test]
#[ignore = "writes src/fpga/estimate/calibration.toml"]
fn fitted_anew() {
    write(Calibration::built_in().unwrap());
}
