//! Thousands of damaged mesh files: the readers answer with a mesh or with one error, and never panic,
//! hang or fill the memory.
//!
//! The damage is deterministic (xorshift): bytes replaced, removed, repeated, swapped for telling ones, or the
//! file cut. Whatever is accepted must go on through topology and quantising without a panic as well.

use subdiv_rtl::fixed::Format;
use subdiv_rtl::mesh::{
    FileFormat, FineMesh, Mesh, Topology, quantise, read_from, shape, widest_format, write,
};
use subdiv_rtl::{Error, Kind};

struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % limit as u64) as usize
    }
}

/// Pieces that parsers trip over.
const TRAPS: [&[u8]; 14] = [
    b"-1",
    b"nan",
    b"1e999",
    b"4294967295",
    b"99999999999999999999",
    b"-9223372036854775808",
    b"\xff\xfe",
    b"\0",
    b"\n",
    b" ",
    b"{",
    b"]",
    b"#",
    b"0",
];

fn damage(file: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = file.to_vec();
    for _ in 0..=random.below(3) {
        let at = random.below(bytes.len());
        let end = (at + 1 + random.below(8)).min(bytes.len());
        match random.below(6) {
            0 => bytes[at] = random.below(256) as u8,
            1 => bytes[at] ^= 1 << random.below(8),
            2 => drop(bytes.drain(at..end)),
            3 => drop(bytes.splice(at..end, TRAPS[random.below(TRAPS.len())].iter().copied())),
            4 => drop(bytes.splice(at..at, file[at.min(file.len())..end.min(file.len())].to_vec())),
            _ => bytes.truncate(at),
        }
        if bytes.is_empty() {
            bytes.push(b'\n');
        }
    }
    bytes
}

/// Everything that happens to a mesh before it is evaluated.
fn use_mesh(mesh: &Mesh) -> Result<(), Error> {
    mesh.triangulated().triangles()?;
    let topology = Topology::new(mesh)?;
    assert!(topology.edge_count() > 0 && topology.components().len() == mesh.faces.len());
    for v in 0..topology.vertex_count() {
        assert_eq!(topology.ring(v).count(), topology.valence(v) as usize);
    }
    topology.boundary_loops();
    quantise(mesh, widest_format(mesh, 24)?).map(|_| ())
}

fn survive(name: &str, format: FileFormat, file: &[u8]) {
    let whole = read_from(file, name, Some(format)).unwrap();
    use_mesh(&whole).unwrap();
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let (mut accepted, mut refused) = (0, 0);
    for _ in 0..4000 {
        let bytes = damage(file, &mut random);
        let guess = if random.below(8) == 0 { None } else { Some(format) };
        match read_from(&bytes[..], name, guess).and_then(|mesh| use_mesh(&mesh)) {
            Ok(()) => accepted += 1,
            Err(error) => {
                refused += 1;
                assert_eq!(error.kind, Kind::Input, "{error}");
                let place = error.place.as_deref().unwrap_or_default();
                assert!(place.contains(name) && error.help.is_some(), "{error}");
                assert!(error.to_string().lines().count() == 3 && error.to_string().len() < 2000, "{error}");
            }
        }
    }
    println!("{name}: {accepted} accepted, {refused} refused");
    assert!(accepted > 0 && refused > 1000, "{name}: the damage is too small or too large to tell anything");
}

fn written(name: &str) -> Vec<u8> {
    let mesh = shape("blob").unwrap();
    let quantised = quantise(&mesh, Format::new(2, 12).unwrap()).unwrap();
    let faces = mesh.triangles().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    write(&path, &FineMesh { format: quantised.format, positions: quantised.positions, faces }).unwrap();
    std::fs::read(path).unwrap()
}

#[test]
fn damaged_obj() {
    survive("a.obj", FileFormat::Obj, &written("a.obj"));
}

#[test]
fn damaged_ply_text() {
    survive("a.ply", FileFormat::Ply, &written("a.ply"));
}

#[test]
fn damaged_ply_binary() {
    let mesh = shape("octahedron").unwrap();
    let mut file =
        b"ply\nformat binary_big_endian 1.0\nelement vertex 6\nproperty double x\nproperty float y\n\
        property double z\nelement face 8\nproperty list uchar int vertex_indices\nend_header\n"
            .to_vec();
    for p in &mesh.positions {
        file.extend(p.x.to_be_bytes());
        file.extend((p.y as f32).to_be_bytes());
        file.extend(p.z.to_be_bytes());
    }
    for face in &mesh.faces {
        file.push(3);
        face.iter().for_each(|v| file.extend(v.to_be_bytes()));
    }
    survive("b.ply", FileFormat::Ply, &file);
}

#[test]
fn damaged_stl_binary() {
    survive("a.stl", FileFormat::Stl, &written("a.stl"));
}

#[test]
fn damaged_stl_text() {
    let mesh = shape("icosahedron").unwrap();
    let mut file = "solid icosahedron\n".to_owned();
    for face in &mesh.faces {
        file += "facet normal 0 0 0\nouter loop\n";
        for &v in face {
            let [x, y, z] = mesh.positions[v as usize].to_array();
            file += &format!("vertex {x} {y} {z}\n");
        }
        file += "endloop\nendfacet\n";
    }
    survive("t.stl", FileFormat::Stl, (file + "endsolid\n").as_bytes());
}

#[test]
fn damaged_off() {
    let mesh = shape("cube-quads").unwrap();
    let mut file = "OFF # a cube\n8 6 12\n".to_owned();
    mesh.positions.iter().for_each(|p| file += &format!("{} {} {}\n", p.x, p.y, p.z));
    mesh.faces.iter().for_each(|f| file += &format!("4 {} {} {} {} 255 0 0\n", f[0], f[1], f[2], f[3]));
    survive("a.off", FileFormat::Off, file.as_bytes());
}

#[test]
fn damaged_inventor() {
    let mesh = shape("cube-quads").unwrap();
    let mut file = "#Inventor V2.1 ascii\nSeparator {\nCoordinate3 {\n  point [\n".to_owned();
    mesh.positions.iter().for_each(|p| file += &format!("{} {} {},\n", p.x, p.y, p.z));
    file += "] }\nIndexedFaceSet {\n materialIndex -1\n coordIndex [\n";
    mesh.faces.iter().for_each(|f| file += &format!("{}, {}, {}, {}, -1,\n", f[0], f[1], f[2], f[3]));
    survive("a.iv", FileFormat::Inventor, (file + "]\n}\n}\n").as_bytes());
}

/// Like `damaged_*`, with bytes that were never a mesh.
#[test]
fn noise() {
    let mut random = Random(7);
    for round in 0..2000 {
        let length = 1 + random.below(400);
        let bytes: Vec<u8> =
            (0..length).map(|_| random.below(if round % 2 == 0 { 256 } else { 128 }) as u8).collect();
        for format in
            [FileFormat::Obj, FileFormat::Off, FileFormat::Ply, FileFormat::Stl, FileFormat::Inventor]
        {
            assert!(read_from(&bytes[..], "noise", Some(format)).is_err());
        }
        let _ = read_from(&bytes[..], "noise", None);
    }
}
