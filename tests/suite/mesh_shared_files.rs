//! The meshes that are shared between projects, where they are at hand: every one reads, is a manifold, and is
//! made of multiples of 2^-12.

use std::path::Path;
use subdiv_rtl::fixed::Format;
use subdiv_rtl::mesh::{Topology, quantise, read};

#[test]
fn shared_meshes_are_manifolds_on_the_grid() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/meshes");
    let Ok(entries) = std::fs::read_dir(&folder) else {
        println!("skipped: there is no folder ../shared/meshes");
        return;
    };
    for path in
        entries.map(|entry| entry.unwrap().path()).filter(|path| path.extension().is_some_and(|e| e == "obj"))
    {
        let mesh = read(&path).unwrap();
        let topology = Topology::new(&mesh).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(topology.component_count(), 1, "{}", mesh.name);
        assert!(quantise(&mesh, Format::new(2, 12).unwrap()).unwrap().rounding.is_exact(), "{}", mesh.name);
    }
}
