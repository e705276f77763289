//! Where problem files, robots and meshes are read from: the disk, or tables embedded in a binary.

use std::io;

/// Reads whole files by path. Paths use `/`; a relative one is relative to whatever the source calls its root.
pub trait Files {
    /// The bytes of one file.
    ///
    /// # Errors
    /// `NotFound` where there is no such file, anything else where it cannot be read.
    fn read(&self, path: &str) -> io::Result<Vec<u8>>;

    /// Folders in which the ROS package `name` may lie, best first (for `package://name/...`).
    ///
    /// The folder of the naming file and its ancestors are searched in any case, after these.
    fn package_folders(&self, _name: &str) -> Vec<String> {
        Vec::new()
    }
}

/// Files on disk.
#[derive(Clone, Copy, Debug, Default)]
pub struct DiskFiles;

impl Files for DiskFiles {
    fn read(&self, path: &str) -> io::Result<Vec<u8>> {
        let size = std::fs::metadata(path)?.len();
        if size > MAX_FILE_BYTES as u64 {
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, too_large(size)));
        }
        std::fs::read(path)
    }
}

/// Files on disk, with ROS packages in known folders.
#[derive(Clone, Debug, Default)]
pub struct PackageFiles {
    /// Package name and its folder.
    pub packages: Vec<(String, String)>,
    /// Folders that are packages, by their own name, or hold them as subfolders, as in `ROS_PACKAGE_PATH`.
    pub search: Vec<String>,
}

impl Files for PackageFiles {
    fn read(&self, path: &str) -> io::Result<Vec<u8>> {
        DiskFiles.read(path)
    }

    fn package_folders(&self, name: &str) -> Vec<String> {
        let named = self.packages.iter().filter(|(package, _)| package == name).map(|(_, folder)| folder.clone());
        let of_search = self.search.iter().flat_map(|folder| {
            let itself = folder.trim_end_matches('/').rsplit('/').next() == Some(name);
            itself.then(|| folder.clone()).into_iter().chain([join(folder, name)])
        });
        named.chain(of_search).collect()
    }
}

/// Files embedded in a binary: path and bytes, as `include_bytes!` gives them.
#[derive(Clone, Copy, Debug)]
pub struct EmbeddedFiles(pub &'static [(&'static str, &'static [u8])]);

impl Files for EmbeddedFiles {
    fn read(&self, path: &str) -> io::Result<Vec<u8>> {
        let path = normalise(path);
        let found = self.0.iter().find(|(name, _)| normalise(name) == path);
        found.map(|(_, bytes)| bytes.to_vec()).ok_or_else(|| io::Error::from(io::ErrorKind::NotFound))
    }
}

/// Largest file that is read (bytes).
pub(crate) const MAX_FILE_BYTES: usize = 64 << 20;

pub(crate) fn too_large(size: u64) -> String {
    format!("{size} bytes, more than the {MAX_FILE_BYTES} that are read")
}

/// The folder of a file, without the trailing `/`; empty for a bare name.
pub(crate) fn folder(path: &str) -> &str {
    match path.rfind('/') {
        Some(0) => "/",
        Some(end) => &path[..end],
        None => "",
    }
}

/// `path` as seen from `folder`; an absolute path stays.
pub(crate) fn join(folder: &str, path: &str) -> String {
    if folder.is_empty() || path.starts_with('/') {
        return normalise(path);
    }
    normalise(&format!("{folder}/{path}"))
}

/// Resolves `.` and `..` textually.
fn normalise(path: &str) -> String {
    let mut parts: Vec<&str> = Vec::new();
    for part in path.split('/') {
        match part {
            "" | "." => {}
            ".." if parts.last().is_some_and(|last| *last != "..") => {
                parts.pop();
            }
            ".." if path.starts_with('/') => {}
            _ => parts.push(part),
        }
    }
    let joined = parts.join("/");
    if path.starts_with('/') { format!("/{joined}") } else { joined }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_paths_are_resolved_from_the_folder_of_the_naming_file() {
        assert_eq!(join(folder("scenes/t00.yaml"), "../robots/fa7.urdf"), "robots/fa7.urdf");
        assert_eq!(join(folder("/a/b/t.yaml"), "../../../x"), "/x");
        assert_eq!(join(folder("t.yaml"), "./x.urdf"), "x.urdf");
        assert_eq!(join("..", "../x"), "../../x");
        assert_eq!(join("/a", "/b/./c"), "/b/c");
    }

    #[test]
    fn embedded_files_are_found_under_any_spelling_of_their_path() {
        let files = EmbeddedFiles(&[("scenes/a.yaml", b"x")]);
        assert_eq!(files.read("./scenes/../scenes/a.yaml").unwrap(), b"x");
        assert_eq!(files.read("b.yaml").unwrap_err().kind(), io::ErrorKind::NotFound);
    }

    #[test]
    fn named_packages_come_before_searched_folders() {
        let files = PackageFiles { packages: vec![("p".into(), "/x/p".into())], search: vec!["/ws/src".into()] };
        assert_eq!(files.package_folders("p"), ["/x/p", "/ws/src/p"]);
        assert_eq!(files.package_folders("q"), ["/ws/src/q"]);
        assert_eq!(files.package_folders("src"), ["/ws/src", "/ws/src/src"], "a searched folder may be the package");
    }
}
