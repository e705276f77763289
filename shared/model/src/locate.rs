//! Where a file lies that another file names: relative to it, or in a ROS package.

use crate::Files;
use crate::file::why_unread;
use crate::files::{MAX_FILE_BYTES, folder, join, too_large};
use crate::problem_error::{Finding, FindingKind, Found, Source, Span};

/// Reads the file that `owner` names at `span`: its path and bytes.
///
/// `reference` is a path relative to the owner, or `package://name/path`, sought in the package's known folders, then in
/// the owner's folder and its ancestors. `what` it is, for the message.
pub(crate) fn locate(
    files: &dyn Files,
    owner: &Source,
    span: Span,
    what: &str,
    reference: &str,
) -> Found<(String, Vec<u8>)> {
    let mut tried = Vec::new();
    for path in candidates(files, &owner.path, reference) {
        match files.read(&path) {
            Ok(bytes) if bytes.len() <= MAX_FILE_BYTES => return Ok((path, bytes)),
            Ok(bytes) => tried.push(format!("{path}: {}", too_large(bytes.len() as u64))),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => tried.push(path),
            Err(error) => tried.push(format!("{path}: {}", why_unread(&error))),
        }
    }
    Err(missing(owner, span, what, reference, &tried))
}

fn missing(owner: &Source, span: Span, what: &str, reference: &str, tried: &[String]) -> Box<Finding> {
    let finding = owner.finding(span, FindingKind::Unreadable, format!("no {what} {reference}"));
    let tried = tried.join(", ");
    match package_of(reference) {
        Some((package, _)) => finding.help(format!(
            "tried: {tried}; say where the package lies with `--package {package}=FOLDER`, ROS_PACKAGE_PATH or AMENT_PREFIX_PATH"
        )),
        None => finding.help(format!("tried: {tried}")),
    }
}

/// Package and path within it.
fn package_of(reference: &str) -> Option<(&str, &str)> {
    let rest = reference.trim().strip_prefix("package://")?;
    Some(rest.split_once('/').unwrap_or((rest, "")))
}

fn candidates(files: &dyn Files, owner: &str, reference: &str) -> Vec<String> {
    let reference = reference.trim();
    let Some((package, path)) = package_of(reference) else {
        return vec![join(folder(owner), reference.strip_prefix("file://").unwrap_or(reference))];
    };
    let mut paths: Vec<String> = files.package_folders(package).iter().map(|folder| join(folder, path)).collect();
    let mut ancestor = folder(owner);
    loop {
        if ancestor.rsplit('/').next() == Some(package) {
            paths.push(join(ancestor, path));
        }
        paths.push(join(ancestor, &format!("{package}/{path}")));
        if ancestor.is_empty() || ancestor == "/" {
            return paths;
        }
        ancestor = folder(ancestor);
    }
}
