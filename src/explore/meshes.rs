//! The meshes of an exploration: where they come from, what they are, and their hash.
//!
//! ```text
//!   file or shape ─► Subject { name, source, hash, mesh }       hash of the points' bits and the faces
//! ```

use std::path::Path;

use super::point::{MeshName, Origin, Scheme};
use crate::error::{Error, Result};
use crate::mesh::{self, Mesh, Topology};

/// A mesh that is explored.
#[derive(Clone, Debug)]
pub struct Subject {
    pub name: MeshName,
    pub mesh: Mesh,
}

/// The largest valence that Loop's look-up tables serve.
const MAX_VALENCE: u32 = 32;

impl Subject {
    /// Reads the file or makes the shape.
    ///
    /// # Errors
    /// Those of reading; a shape that does not exist.
    pub fn load(source: &Origin, triangulate: bool) -> Result<Subject> {
        let mesh = match source {
            Origin::File(path) => mesh::read(Path::new(path))?,
            Origin::Shape(name) => mesh::shape(name)?,
        };
        let mesh = if triangulate { mesh.triangulated() } else { mesh };
        let name = MeshName { name: mesh.name.clone(), source: source.clone(), hash: hash(&mesh) };
        Ok(Subject { name, mesh })
    }

    /// Loads the mesh that a point names and refuses another one that has taken its place.
    ///
    /// # Errors
    /// As [`Subject::load`]; a mesh with another hash.
    pub fn reload(wanted: &MeshName) -> Result<Subject> {
        let found = Subject::load(&wanted.source, false)?;
        if found.name.hash == wanted.hash {
            return Ok(found);
        }
        let cut = Subject::load(&wanted.source, true)?;
        if cut.name.hash == wanted.hash {
            return Ok(cut);
        }
        Err(Error::input(format!("the mesh {} has changed since the plan was made", wanted.name))
            .at(found.mesh.place())
            .help("plan again with 'explore plan', or restore the mesh"))
    }

    /// The scheme that its faces are made for: triangles go by Loop's, everything else by Catmull and Clark's.
    pub fn scheme(&self) -> Scheme {
        if self.mesh.is_triangle_mesh() { Scheme::Loop } else { Scheme::CatmullClark }
    }

    /// Refuses a mesh on which the scheme is not defined.
    ///
    /// # Errors
    /// A polygon for Loop's scheme, no manifold, a valence beyond the tables.
    pub fn check(&self, scheme: Scheme) -> Result<()> {
        let topology = Topology::new(&self.mesh)?;
        if scheme == Scheme::Loop {
            self.mesh.triangles()?;
            topology.check_valences(&self.mesh, 3..=MAX_VALENCE, 2..=MAX_VALENCE)?;
        }
        Ok(())
    }
}

/// The hash of what a mesh is made of; its name and file do not enter.
fn hash(mesh: &Mesh) -> String {
    let mut hasher = blake3::Hasher::new();
    for point in &mesh.positions {
        // -0 and 0 are the same point.
        for x in point.to_array() {
            hasher.update(&(x + 0.0).to_bits().to_le_bytes());
        }
    }
    for face in &mesh.faces {
        hasher.update(&(face.len() as u32).to_le_bytes());
        for v in face {
            hasher.update(&v.to_le_bytes());
        }
    }
    hasher.finalize().to_hex()[..32].to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_that_of_the_content() {
        let torus = mesh::shape("torus").unwrap();
        let mut other = torus.clone();
        other.name = "another name".into();
        assert_eq!(hash(&torus), hash(&other));
        other.positions[3].y += 1e-9;
        assert_ne!(hash(&torus), hash(&other));
        let mut turned = torus.clone();
        turned.faces[0].rotate_left(1);
        assert_ne!(hash(&torus), hash(&turned));
    }

    #[test]
    fn a_mesh_that_was_cut_is_found_again_and_a_changed_one_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("square.obj");
        std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n").unwrap();
        let source = Origin::File(path.display().to_string());
        let cut = Subject::load(&source, true).unwrap();
        assert_eq!((cut.scheme(), cut.mesh.faces.len()), (Scheme::Loop, 2));
        assert_eq!(Subject::reload(&cut.name).unwrap().mesh.faces.len(), 2);
        std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 1 0\nf 1 2 3 4\n").unwrap();
        assert_eq!(Subject::reload(&cut.name).unwrap_err().exit_status(), 3);
    }
}
