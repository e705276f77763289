//! The folder of a run, which proves by a lock that the run is alive, and the removal of what dead runs have left.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use bus::Iceoryx2Place;
use nix::sys::statfs::{TMPFS_MAGIC, statfs};

/// Where the system keeps shared memory.
const SHARED_MEMORY: &str = "/dev/shm";
/// What the names of runs begin with.
const NAME_PREFIX: &str = "mrtamp-";
/// Marks a folder that is still being made; the process follows.
const IN_THE_MAKING: &str = ".made-by-";
/// The locked file.
const LOCK: &str = "lock";

/// The folder of a live run. Dropping it removes everything that the run has left.
#[derive(Debug)]
pub struct RunFolder {
    base: PathBuf,
    name: String,
    _lock: File,
}

impl RunFolder {
    /// Removes what dead runs have left, and makes the folder of a new run.
    ///
    /// # Errors
    /// When no folder can be made.
    pub fn create() -> io::Result<Self> {
        Self::create_in(&base())
    }

    fn create_in(base: &Path) -> io::Result<Self> {
        sweep(base);
        let name = fresh_name();
        let making = base.join(format!("{name}{IN_THE_MAKING}{}", std::process::id()));
        fs::DirBuilder::new().mode(0o700).create(&making)?;
        let lock = OpenOptions::new().write(true).create_new(true).open(making.join(LOCK))?;
        lock.lock()?;
        // Under its name only once it is locked: whoever sees it there without a lock may remove it.
        fs::rename(&making, base.join(&name))?;
        Ok(Self { base: base.to_owned(), name, _lock: lock })
    }

    /// Name of the run.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where the run's shared memory is.
    #[must_use]
    pub fn place(&self) -> Iceoryx2Place {
        place(&self.base, &self.name)
    }
}

impl Drop for RunFolder {
    fn drop(&mut self) {
        remove(&self.base, &self.name);
    }
}

/// Where the shared memory of a run is that somebody else has made.
///
/// # Errors
/// When there is no such run.
pub fn find(name: &str) -> io::Result<Iceoryx2Place> {
    let bases = [PathBuf::from(SHARED_MEMORY), std::env::temp_dir()];
    let found = bases.iter().find(|base| is_name(name) && base.join(name).join(LOCK).exists());
    found.map(|base| place(base, name)).ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, format!("no run {name}")))
}

fn place(base: &Path, name: &str) -> Iceoryx2Place {
    Iceoryx2Place { root: base.join(name), prefix: format!("{name}_"), run: name.to_owned() }
}

/// Memory is faster than disk, where there is a file system in it.
fn base() -> PathBuf {
    let in_memory = statfs(SHARED_MEMORY).is_ok_and(|stat| stat.filesystem_type() == TMPFS_MAGIC);
    if in_memory { PathBuf::from(SHARED_MEMORY) } else { std::env::temp_dir() }
}

fn fresh_name() -> String {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos());
    format!("{NAME_PREFIX}{:x}-{:08x}", std::process::id(), (now / 1000) as u32)
}

fn is_name(name: &str) -> bool {
    name.strip_prefix(NAME_PREFIX).is_some_and(|rest| {
        rest.split_once('-').is_some_and(|(process, time)| {
            let is_hex = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_hexdigit());
            is_hex(process) && is_hex(time)
        })
    })
}

/// Removes what runs have left whose owner is gone. What cannot be removed is left to the next start.
fn sweep(base: &Path) {
    let Ok(me) = fs::metadata("/proc/self").map(|metadata| metadata.uid()) else { return };
    for entry in fs::read_dir(base).into_iter().flatten().flatten() {
        let is_mine = entry.metadata().is_ok_and(|metadata| metadata.is_dir() && metadata.uid() == me);
        let name = entry.file_name();
        let Some(name) = name.to_str().filter(|_| is_mine) else { continue };
        if let Some((run, process)) = name.split_once(IN_THE_MAKING) {
            if is_name(run) && !Path::new("/proc").join(process).exists() {
                let _ = fs::remove_dir_all(base.join(name));
            }
        } else if is_name(name) && is_dead(&base.join(name)) {
            remove(base, name);
        }
    }
}

/// Whether nobody holds the lock of a run.
fn is_dead(folder: &Path) -> bool {
    match File::open(folder.join(LOCK)) {
        Ok(lock) => !matches!(lock.try_lock(), Err(TryLockError::WouldBlock)),
        Err(error) => error.kind() == io::ErrorKind::NotFound,
    }
}

/// Removes a run's shared memory, then its folder: as long as something is left, the folder is.
fn remove(base: &Path, name: &str) {
    let prefix = format!("{name}_");
    for entry in fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten() {
        if entry.file_name().to_str().is_some_and(|file| file.starts_with(&prefix)) {
            let _ = fs::remove_file(entry.path());
        }
    }
    let _ = fs::remove_dir_all(base.join(name));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_live_run_is_left_alone_and_a_dead_one_is_swept() {
        let base = tempfile::tempdir().unwrap();
        let live = RunFolder::create_in(base.path()).unwrap();
        fs::write(live.place().root.join("something"), "x").unwrap();
        let dead = base.path().join("mrtamp-1-2");
        fs::create_dir(&dead).unwrap();
        fs::write(dead.join(LOCK), "").unwrap();
        let half_removed = base.path().join("mrtamp-1-3");
        fs::create_dir(&half_removed).unwrap();
        let other = base.path().join("mrtamp-of-somebody");
        fs::create_dir(&other).unwrap();
        sweep(base.path());
        assert!(live.place().root.join("something").exists());
        assert!(!dead.exists() && !half_removed.exists());
        assert!(other.exists(), "not a name that a run can have");
    }

    #[test]
    fn a_folder_in_the_making_belongs_to_its_maker_as_long_as_that_lives() {
        let base = tempfile::tempdir().unwrap();
        let alive = base.path().join(format!("mrtamp-1-2{IN_THE_MAKING}{}", std::process::id()));
        let gone = base.path().join(format!("mrtamp-1-3{IN_THE_MAKING}4194999"));
        fs::create_dir(&alive).unwrap();
        fs::create_dir(&gone).unwrap();
        sweep(base.path());
        assert!(alive.exists() && !gone.exists());
    }

    #[test]
    fn the_end_of_a_run_removes_its_folder_and_its_shared_memory_and_nobody_elses() {
        let base = tempfile::tempdir().unwrap();
        let run = RunFolder::create_in(base.path()).unwrap();
        let (root, own) = (run.place().root, Path::new(SHARED_MEMORY).join(format!("{}_x", run.name())));
        let others = Path::new(SHARED_MEMORY).join(format!("{}0_x", run.name()));
        fs::write(&own, "").unwrap();
        fs::write(&others, "").unwrap();
        drop(run);
        let (own, others_left) = (own.exists(), others.exists());
        fs::remove_file(&others).unwrap();
        assert!(!root.exists() && !own && others_left);
    }

    #[test]
    fn runs_are_found_by_name_and_nothing_else_is() {
        let run = RunFolder::create().unwrap();
        assert_eq!(find(run.name()).unwrap(), run.place());
        let name = run.name().to_owned();
        drop(run);
        assert!(find(&name).is_err());
        assert!(find("../etc").is_err());
    }
}
