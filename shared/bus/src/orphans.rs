//! Shared memory that its maker left half made because it was killed in between.
//!
//! Whoever opens such a file waits for its maker to go on. iceoryx2 0.10 waits without end if the file is still empty.

use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};

/// Where the system keeps shared memory.
const SHARED_MEMORY: &str = "/dev/shm";
/// Makers may be busy; openers hold the file for moments only.
const LOOKS: u32 = 5;

/// Removes files whose names begin so, that are not finished, and that no process has open.
pub(crate) fn remove_unfinished(prefix: &str) {
    remove_unfinished_in(Path::new(SHARED_MEMORY), prefix);
}

fn remove_unfinished_in(folder: &Path, prefix: &str) {
    let mut suspects = unfinished(folder, prefix);
    for _ in 0..LOOKS {
        if suspects.is_empty() {
            return;
        }
        let open = open_files(folder);
        // Finished meanwhile: its maker is alive. Not finished and not open: its maker is gone.
        suspects.retain(|file| is_unfinished(file));
        for orphan in suspects.extract_if(.., |file| !open.contains(file)) {
            let _ = fs::remove_file(orphan);
        }
    }
}

fn unfinished(folder: &Path, prefix: &str) -> Vec<PathBuf> {
    let named = |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(prefix));
    let files = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    files.filter(named).filter(|file| is_unfinished(file)).collect()
}

/// A finished file has a size, and its owner may read it.
fn is_unfinished(file: &Path) -> bool {
    let is = |metadata: fs::Metadata| {
        metadata.is_file() && (metadata.size() == 0 || metadata.permissions().mode() & 0o400 == 0)
    };
    fs::metadata(file).is_ok_and(is)
}

/// Files of a folder that some process of this user has open.
fn open_files(folder: &Path) -> Vec<PathBuf> {
    let folders_of = |path: &str| fs::read_dir(path).into_iter().flatten().flatten();
    let processes = folders_of("/proc")
        .filter(|entry| entry.file_name().to_str().is_some_and(|name| name.bytes().all(|byte| byte.is_ascii_digit())));
    let descriptors = processes.flat_map(|process| folders_of(&process.path().join("fd").to_string_lossy()));
    descriptors
        .filter_map(|descriptor| fs::read_link(descriptor.path()).ok())
        .filter(|file| file.starts_with(folder))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_unfinished_and_open_nowhere_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| folder.path().join(name);
        let being_made = fs::File::create(file("run_being_made")).unwrap();
        fs::write(file("run_empty"), "").unwrap();
        fs::write(file("run_closed"), "content").unwrap();
        fs::set_permissions(file("run_closed"), fs::Permissions::from_mode(0o200)).unwrap();
        fs::write(file("run_finished"), "content").unwrap();
        fs::write(file("other_empty"), "").unwrap();
        remove_unfinished_in(folder.path(), "run_");
        let left = |name: &str| file(name).exists();
        assert!(left("run_being_made") && left("run_finished") && left("other_empty"));
        assert!(!left("run_empty") && !left("run_closed"));
        drop(being_made);
        remove_unfinished_in(folder.path(), "run_");
        assert!(!left("run_being_made"));
    }
}
