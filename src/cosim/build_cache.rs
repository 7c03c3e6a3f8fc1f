//! Compiled simulators, kept by the hash of all that went into them.
//!
//! ```text
//! <cache>/simulators/<hash>/simulator      the program
//!                           used           touched at each use; the oldest go first
//! <cache>/simulators/building-xxxx/        being copied; renamed into place when complete
//! ```
//!
//! A rename either happens or does not, so that several processes may build the same thing at once:
//! the first one wins, the others use its copy.

use super::Settings;
use crate::{Error, Kind, Result};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Entries beyond this number are removed, those unused for the longest time first.
const ENTRIES: usize = 64;
/// A folder that is still being built after so long belongs to a process that died.
const ABANDONED: Duration = Duration::from_secs(24 * 3600);
const PROGRAM: &str = "simulator";
const USED: &str = "used";
const BUILDING: &str = "building-";

pub(super) struct BuildCache {
    root: PathBuf,
}

impl BuildCache {
    /// In `settings.cache`, else `$SUBDIV_RTL_CACHE`, else `subdiv-rtl` in the user's cache folder.
    pub(super) fn open(settings: &Settings) -> Result<BuildCache> {
        let folder = settings.cache.clone().or_else(user_cache).ok_or_else(|| {
            Error::usage("there is no folder to keep compiled simulators in")
                .help("set SUBDIV_RTL_CACHE to a folder that can be written")
        })?;
        let root = folder.join("simulators");
        fs::create_dir_all(&root).map_err(|error| cannot(&root, error))?;
        Ok(BuildCache { root: root.canonicalize().map_err(|error| cannot(&root, error))? })
    }

    /// The program of that hash, if it is there; marks it as used.
    pub(super) fn find(&self, hash: &str) -> Option<PathBuf> {
        let entry = self.root.join(hash);
        let program = entry.join(PROGRAM);
        program.is_file().then(|| {
            // If it cannot be marked it is only removed sooner.
            let _ = fs::write(entry.join(USED), b"");
            program
        })
    }

    /// Keeps a freshly built program under its hash and says where it lies.
    pub(super) fn keep(&self, hash: &str, built: &Path) -> Result<PathBuf> {
        let here = |error| cannot(&self.root, error);
        let new = tempfile::Builder::new().prefix(BUILDING).tempdir_in(&self.root).map_err(here)?;
        fs::copy(built, new.path().join(PROGRAM)).map_err(here)?;
        fs::write(new.path().join(USED), b"").map_err(here)?;
        let entry = self.root.join(hash);
        match fs::rename(new.path(), &entry) {
            Ok(()) => drop(new.keep()),
            Err(_) if entry.join(PROGRAM).is_file() => {}
            Err(error) => return Err(here(error)),
        }
        self.evict(hash);
        Ok(entry.join(PROGRAM))
    }

    /// Removes what is too old or too much; failures leave things for the next time.
    fn evict(&self, newest: &str) {
        let Ok(folders) = fs::read_dir(&self.root) else { return };
        let mut entries = Vec::new();
        for folder in folders.flatten() {
            let path = folder.path();
            let name = folder.file_name().to_string_lossy().into_owned();
            let building = name.starts_with(BUILDING);
            let stamp = if building { path.clone() } else { path.join(USED) };
            let used = fs::metadata(stamp).and_then(|data| data.modified());
            let used = used.unwrap_or(SystemTime::UNIX_EPOCH);
            let age = SystemTime::now().duration_since(used).unwrap_or_default();
            if building && age > ABANDONED {
                let _ = fs::remove_dir_all(path);
            } else if !building && name != newest {
                entries.push((used, path));
            }
        }
        entries.sort();
        let surplus = (entries.len() + 1).saturating_sub(ENTRIES);
        for (_, path) in entries.into_iter().take(surplus) {
            let _ = fs::remove_dir_all(path);
        }
    }
}

/// The hash of named texts: names and lengths are part of it, so that nothing can move between them.
pub(crate) fn hash<'a>(parts: impl IntoIterator<Item = (&'a str, &'a str)>) -> String {
    let mut hasher = blake3::Hasher::new();
    for (name, text) in parts {
        for piece in [name, text] {
            hasher.update(&(piece.len() as u64).to_le_bytes());
            hasher.update(piece.as_bytes());
        }
    }
    hasher.finalize().to_hex()[..32].to_string()
}

/// The cache folder of the program.
pub(crate) fn user_cache() -> Option<PathBuf> {
    let set = |name| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    set("SUBDIV_RTL_CACHE")
        .or_else(|| Some(set("XDG_CACHE_HOME")?.join("subdiv-rtl")))
        .or_else(|| Some(set("HOME")?.join(".cache/subdiv-rtl")))
}

fn cannot(folder: &Path, error: io::Error) -> Error {
    Error::new(Kind::Usage, format!("cannot keep compiled simulators: {error}"))
        .at(folder.display())
        .help("set SUBDIV_RTL_CACHE to a folder that can be written")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cache_in(folder: &tempfile::TempDir) -> BuildCache {
        let cache = Some(folder.path().to_path_buf());
        BuildCache::open(&Settings { cache, ..Settings::default() }).unwrap()
    }

    #[test]
    fn what_was_kept_is_found_again() {
        let folder = tempfile::tempdir().unwrap();
        let (cache, built) = (cache_in(&folder), folder.path().join("built"));
        fs::write(&built, "program").unwrap();
        assert_eq!(cache.find("a"), None);
        let kept = cache.keep("a", &built).unwrap();
        assert_eq!(cache.find("a"), Some(kept.clone()));
        assert_eq!(fs::read(kept).unwrap(), b"program");
    }

    #[test]
    fn the_same_thing_may_be_built_by_many_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let (cache, built) = (cache_in(&folder), folder.path().join("built"));
        fs::write(&built, vec![7; 100_000]).unwrap();
        std::thread::scope(|scope| {
            for _ in 0..16 {
                scope.spawn(|| {
                    let kept = cache.keep("same", &built).unwrap();
                    assert_eq!(fs::read(kept).unwrap().len(), 100_000);
                });
            }
        });
        assert_eq!(fs::read_dir(&cache.root).unwrap().count(), 1, "something was left lying about");
    }

    #[test]
    fn the_entry_unused_for_the_longest_time_goes_first() {
        let folder = tempfile::tempdir().unwrap();
        let (cache, built) = (cache_in(&folder), folder.path().join("built"));
        fs::write(&built, "program").unwrap();
        let age = |hash: &str, seconds: u64| {
            let stamp = fs::File::create(cache.root.join(hash).join(USED)).unwrap();
            stamp.set_modified(SystemTime::now() - Duration::from_secs(seconds)).unwrap();
        };
        for at in 0..ENTRIES {
            cache.keep(&format!("{at}"), &built).unwrap();
            age(&format!("{at}"), 1000 - at as u64);
        }
        cache.find("0");
        cache.keep("new", &built).unwrap();
        let there: Vec<_> = ["0", "1", "2", "new"].map(|hash| cache.find(hash).is_some()).into();
        assert_eq!(there, [true, false, true, true]);
    }

    #[test]
    fn the_hash_tells_names_from_texts() {
        assert_ne!(hash([("a", "bc")]), hash([("ab", "c")]));
        assert_ne!(hash([("a", "b"), ("c", "d")]), hash([("c", "d"), ("a", "b")]));
    }
}
