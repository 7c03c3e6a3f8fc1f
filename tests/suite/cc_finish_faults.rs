//! Verification of the verification: single-cell faults put into the finishing stage are caught by its comparison with
//! the reference.
//!
//! What the sample leaves is of three sorts: faults that change nothing (a table entry for a valence below 3, the
//! partner of a vertex that is always the one in the middle), carries so long that random numbers do not make them
//! (the linear forms do), and a normal that is shifted by a place less before it is made a unit vector.

use std::collections::BTreeMap;

use crate::cc_meshes::Random;
use crate::cc_stage::{Case, Stage, case, module, random_window};
use subdiv_rtl::cores::cc_strip::finish::Kind as Normals;
use subdiv_rtl::hdl::Flat;
use subdiv_rtl::hdl::fault::{self, Kind};

#[test]
fn faults_of_the_finishing_stage_are_caught() {
    let small = Case { width: 6, levels: [1, 2], max_valence: 6, extra_fraction: 12, ..case() };
    for normals in [Some((Normals::Faces, 2, Some(8))), Some((Normals::Limit, 2, Some(8)))] {
        let case = Case { normals, ..small };
        let flat = Flat::new(&module(case.parameters()).0).unwrap();
        let mut random = Random(2);
        let mut windows =
            |level: u32| (0..100).map(|_| random_window(&case, level, &mut random)).collect::<Vec<_>>();
        let windows = [windows(1), windows(2)];
        let passes = |flat: Flat| {
            let levels = windows[0].iter().zip(&windows[1]).flat_map(|(a, b)| [(1, a), (2, b)]);
            Stage::of(case, flat).run_levels(&levels.collect::<Vec<_>>()).is_ok()
        };
        assert!(passes(flat.clone()));
        let (mut caught, mut missed): (BTreeMap<_, u32>, BTreeMap<_, Vec<String>>) = Default::default();
        for fault in fault::all(&flat).iter().step_by(7) {
            let Ok(broken) = fault.apply(&flat) else { continue };
            match passes(broken) {
                true => missed.entry(fault.kind()).or_default().push(fault.to_string()),
                false => *caught.entry(fault.kind()).or_default() += 1,
            }
        }
        for (kind, caught) in caught {
            let missed = missed.remove(&kind).unwrap_or_default();
            println!("{kind:?}: {caught} caught, {} missed", missed.len());
            let percent = if matches!(kind, Kind::Carry | Kind::Stuck) { 85 } else { 95 };
            assert!(caught * 100 >= percent * (caught + missed.len() as u32), "{kind:?}: {missed:#?}");
        }
        assert!(missed.is_empty(), "a kind of which no fault is caught: {missed:?}");
    }
}
