//! Timing.
use std::time::Instant;
use subdiv_rtl::cores::loop_fd::RegisterForm;
use subdiv_rtl::explore::{meshes::*, point::*, *};
fn main() {
    use subdiv_rtl::fixed::{Fractions, Reduced};
    use subdiv_rtl::surface::precision::{of_patch, worst::*};
    for (l, f) in [
        (3, 8),
        (4, 13),
        (5, 17),
        (6, 21),
        (7, 25),
        (8, 29),
        (8, 20),
        (5, 8),
        (4, 5),
        (6, 10),
        (9, 30),
        (10, 34),
    ] {
        let r = Reduced::new(Fractions::uniform(f).unwrap());
        let b = of_patch(r, l).largest().to_f64_up();
        let p = |s| points(r, l, 24, s).map(|c| c.error_lsb(f) / b);
        let t = Instant::now();
        println!("{l} {f} {:?} {:?} {:?}", p(Side::Above), p(Side::Below), t.elapsed());
    }

    let blob = Subject::load(&Origin::Shape("blob".into()), false).unwrap();
    let mut d = Design {
        scheme: Scheme::Loop,
        coordinates: "Q12.12".parse().unwrap(),
        level: 5,
        precision: Precision::Uniform(17),
        table: 40,
        rounding: subdiv_rtl::fixed::Rounding::HalfUp,
        registers: RegisterForm::Minimal20,
    };
    let t = Instant::now();
    let s = loop_fd::Stage::new(&blob, d.coordinates, 5).unwrap();
    println!("stage {:?}", t.elapsed());
    for p in [Precision::Exact, Precision::Uniform(17), Precision::Progressive([8, 11, 15, 17, 18])] {
        d.precision = p;
        let t = Instant::now();
        for _ in 0..10 {
            s.measure(&d).unwrap().errors();
        }
        println!("measure {:?}", t.elapsed() / 10);
        let t = Instant::now();
        for _ in 0..10 {
            s.measure(&d).unwrap().cracks();
        }
        println!("measure+cracks {:?}", t.elapsed() / 10);
        let t = Instant::now();
        for _ in 0..10 {
            loop_fd::worst(&d).unwrap();
        }
        println!("worst {:?}", t.elapsed() / 10);
        let t = Instant::now();
        for _ in 0..10 {
            s.bound(&d).unwrap();
        }
        println!("bound {:?}", t.elapsed() / 10);
        let t = Instant::now();
        let mut c = None;
        for _ in 0..10 {
            c = Some(subdiv_rtl::cores::loop_fd::build(s.parameters(&d).unwrap()).unwrap());
        }
        println!("build {:?}", t.elapsed() / 10);
        let t = Instant::now();
        for _ in 0..10 {
            cost::Cost::of(c.as_ref().unwrap());
        }
        println!("cost {:?}", t.elapsed() / 10);
    }
}
