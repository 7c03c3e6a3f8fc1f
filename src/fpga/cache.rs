//! What the tools made, kept by the hash of all that went into it.
//!
//! ```text
//!   <cache>/synth/netlist-<hash>.json      of the sources, the script and the version of Yosys
//!   <cache>/synth/timing-<hash>.json       of the netlist, the arguments, the seed and the version of nextpnr
//! ```

use std::fs;
use std::path::PathBuf;

use crate::cosim::{Settings, user_cache};
use crate::error::Result;
use crate::files::write_whole;

/// Files beyond this number are removed, the oldest first: netlists are large.
const ENTRIES: usize = 200;

/// A folder, or none where nothing is to be kept.
#[derive(Clone, Debug)]
pub struct Cache(Option<PathBuf>);

impl Cache {
    /// The user's; a folder that cannot be made keeps nothing.
    pub fn open(settings: &Settings, wanted: bool) -> Cache {
        let folder = settings.cache.clone().or_else(user_cache).map(|folder| folder.join("synth"));
        Cache(folder.filter(|folder| wanted && fs::create_dir_all(folder).is_ok()))
    }

    /// What is kept under a name.
    pub fn find(&self, kind: &str, hash: &str) -> Option<Vec<u8>> {
        let path = self.0.as_ref()?.join(format!("{kind}-{hash}.json"));
        let found = fs::read(&path).ok()?;
        // Used again: it is removed later.
        let _ = fs::File::open(&path).and_then(|file| file.set_modified(std::time::SystemTime::now()));
        Some(found)
    }

    /// Keeps it.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn keep(&self, kind: &str, hash: &str, bytes: &[u8]) -> Result<()> {
        let Some(folder) = &self.0 else { return Ok(()) };
        write_whole(&folder.join(format!("{kind}-{hash}.json")), bytes)?;
        self.evict();
        Ok(())
    }

    fn evict(&self) {
        let Some(Ok(files)) = self.0.as_ref().map(fs::read_dir) else { return };
        let mut files: Vec<_> = files
            .flatten()
            .filter_map(|file| Some((file.metadata().ok()?.modified().ok()?, file.path())))
            .collect();
        files.sort();
        let surplus = files.len().saturating_sub(ENTRIES);
        for (_, path) in files.into_iter().take(surplus) {
            let _ = fs::remove_file(path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_kept_is_found_again_unless_nothing_is_wanted() {
        let folder = tempfile::tempdir().unwrap();
        let settings = Settings { cache: Some(folder.path().to_path_buf()), ..Settings::default() };
        let cache = Cache::open(&settings, true);
        assert_eq!(cache.find("netlist", "a"), None);
        cache.keep("netlist", "a", b"{}").unwrap();
        assert_eq!(cache.find("netlist", "a").as_deref(), Some(&b"{}"[..]));
        let none = Cache::open(&settings, false);
        none.keep("netlist", "b", b"{}").unwrap();
        assert_eq!((none.find("netlist", "a"), cache.find("netlist", "b")), (None, None));
    }
}
