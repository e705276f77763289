//! Where ROS packages lie that files name as `package://name/path`.

use clap::Args;
use model::PackageFiles;

/// Arguments of every command that reads robots from files.
#[derive(Args, Clone, Debug, Default)]
pub struct PackageArgs {
    /// Folder of the ROS package that `package://NAME/...` means; may be given several times. ROS_PACKAGE_PATH and
    /// AMENT_PREFIX_PATH are searched after these, then the folder of the naming file and those around it.
    #[arg(long = "package", value_name = "NAME=FOLDER", value_parser = named_folder)]
    pub packages: Vec<(String, String)>,
}

impl PackageArgs {
    /// Files on disk, with the packages named here and in the environment.
    #[must_use]
    pub fn files(&self) -> PackageFiles {
        let variable = |name: &str| std::env::var(name).unwrap_or_default();
        let search = search_folders(&variable("ROS_PACKAGE_PATH"), &variable("AMENT_PREFIX_PATH"));
        PackageFiles { packages: self.packages.clone(), search }
    }

    /// The same arguments for a program that is started.
    #[must_use]
    pub fn to_arguments(&self) -> Vec<String> {
        self.packages.iter().flat_map(|(name, folder)| ["--package".to_owned(), format!("{name}={folder}")]).collect()
    }
}

fn named_folder(argument: &str) -> Result<(String, String), String> {
    match argument.split_once('=') {
        Some((name, folder)) if !name.is_empty() && !folder.is_empty() => Ok((name.to_owned(), folder.to_owned())),
        _ => Err("give a package's name and its folder, such as my_robot=/home/me/my_robot".to_owned()),
    }
}

/// Folders that hold packages: those of ROS 1's list, and `share` of each prefix of ROS 2's.
fn search_folders(ros_package_path: &str, ament_prefix_path: &str) -> Vec<String> {
    let folders = |list: &str| -> Vec<String> {
        list.split(':')
            .filter(|folder| !folder.is_empty())
            .map(|folder| folder.trim_end_matches('/').to_owned())
            .collect()
    };
    let of_prefixes = folders(ament_prefix_path).into_iter().map(|prefix| format!("{prefix}/share"));
    folders(ros_package_path).into_iter().chain(of_prefixes).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packages_lie_in_the_folders_of_ros_1_and_in_the_shares_of_ros_2() {
        let folders = search_folders("/ws/src:/opt/ros/noetic/share/:", "/opt/ros/jazzy");
        assert_eq!(folders, ["/ws/src", "/opt/ros/noetic/share", "/opt/ros/jazzy/share"]);
        assert!(search_folders("", "").is_empty());
    }

    #[test]
    fn a_package_is_named_with_its_folder() {
        assert_eq!(named_folder("a=b=c").unwrap(), ("a".to_owned(), "b=c".to_owned()));
        assert!(["a", "=b", "a="].into_iter().all(|bad| named_folder(bad).is_err()));
    }
}
