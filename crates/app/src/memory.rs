//! The memory that a run takes and the memory that there is: a run that does not fit is refused before it begins, not killed
//! by the system in the middle.

use crate::format::bytes;
use crate::setup::Problem;
use estar_solver::memory_needed;
use std::fs;
use std::path::Path;

/// While a mesh is read, its file and what is made of it are in memory, about as much again.
const BYTES_PER_BYTE_OF_MESH: u64 = 2;
/// A mesh that is made: its nodes, elements, labels and groups.
const BYTES_PER_NEW_ELEMENT: u64 = 200;
/// A frame on its way, with its grid: bytes of numbers and of what they are packed into, per node and per element.
const FRAME_PER_NODE: usize = 56;
const FRAME_PER_ELEMENT: usize = 100;

/// Bytes that a run of a problem takes beside those that it has taken already, about.
pub fn needed(problem: &Problem) -> u64 {
    let mesh = &problem.mesh;
    // the thread that writes the frames has a mesh of its own
    let frames = mesh.node_count() * (FRAME_PER_NODE + 32) + mesh.element_count() * (FRAME_PER_ELEMENT + 40);
    (memory_needed(mesh, &problem.model) + frames) as u64
}

/// What can be done about a shortage.
pub const HELP: &str = "take a coarser mesh or a machine with more memory, or end other programs";

/// Why the mesh of a file cannot be read, if it does not fit.
pub fn shortage_of_mesh(path: &Path) -> Option<String> {
    // a file that cannot be looked at is told of when it is read
    let size = fs::metadata(path).map_or(0, |metadata| metadata.len());
    shortage(&format!("reading {}", path.display()), size.saturating_mul(BYTES_PER_BYTE_OF_MESH))
}

/// Why a mesh of so many elements cannot be made, if it does not fit.
pub fn shortage_of_new_mesh(element_count: u64) -> Option<String> {
    shortage("this mesh", element_count.saturating_mul(BYTES_PER_NEW_ELEMENT))
}

/// Why a problem cannot be run, if it does not fit.
pub fn shortage_of_problem(problem: &Problem) -> Option<String> {
    shortage("this run", needed(problem))
}

fn shortage(what: &str, needed: u64) -> Option<String> {
    let available = available().filter(|available| needed > *available)?;
    let [needed, available] = [needed, available].map(|count| bytes(count as f64));
    Some(format!("{what} needs about {needed} of memory, and {available} are left"))
}

/// Bytes that this process may still take, where the system tells (Linux): of the machine, of the control groups that it is
/// in, of its own limit.
pub fn available() -> Option<u64> {
    available_below(Path::new("/"))
}

fn available_below(root: &Path) -> Option<u64> {
    let read = |path: &str| fs::read_to_string(root.join(path.trim_start_matches('/'))).unwrap_or_default();
    let of_machine = kilobytes(&read("proc/meminfo"), "MemAvailable:");
    let of_groups = read("proc/self/cgroup").lines().filter_map(|line| of_groups(line, &read)).min();
    let limits = read("proc/self/limits");
    let limit = limits.lines().find_map(|line| line.strip_prefix("Max address space"));
    let limit: Option<u64> = limit.and_then(|line| line.split_whitespace().next()?.parse().ok());
    let taken = kilobytes(&read("proc/self/status"), "VmSize:").unwrap_or(0);
    let of_process = limit.map(|limit| limit.saturating_sub(taken));
    [of_machine, of_groups, of_process].into_iter().flatten().min()
}

/// The value of a line such as `VmSize:   1234 kB`, in bytes.
fn kilobytes(text: &str, key: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    Some(1024 * line.trim().trim_end_matches("kB").trim().parse::<u64>().ok()?)
}

/// What a line of /proc/self/cgroup leaves: `0::/a/b` (version 2) or `7:memory:/a/b` (version 1), here and in every group
/// around it.
fn of_groups(line: &str, read: &impl Fn(&str) -> String) -> Option<u64> {
    let mut parts = line.splitn(3, ':');
    let (_, controllers, group) = (parts.next()?, parts.next()?, parts.next()?);
    let (folder, limit, usage) = match controllers {
        "" => ("sys/fs/cgroup", "memory.max", "memory.current"),
        "memory" => ("sys/fs/cgroup/memory", "memory.limit_in_bytes", "memory.usage_in_bytes"),
        _ => return None,
    };
    let left = |group: &Path| -> Option<u64> {
        let number = |name: &str| read(&format!("{folder}{}/{name}", group.display()).replace("//", "/"));
        let limit: u64 = number(limit).trim().parse().ok()?;
        let usage: u64 = number(usage).trim().parse().ok()?;
        // pages of files that nobody has open are given back when they are needed
        let statistics = number("memory.stat");
        let cached = statistics.lines().find_map(|line| line.strip_prefix("inactive_file "));
        let cached: u64 = cached.and_then(|value| value.trim().parse().ok()).unwrap_or(0);
        Some(limit.saturating_sub(usage.saturating_sub(cached)))
    };
    Path::new(group).ancestors().filter_map(left).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A root with these files.
    fn left(files: &[(&str, &str)]) -> Option<u64> {
        let root = tempfile::tempdir().unwrap();
        for (path, text) in files {
            let path = root.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        available_below(root.path())
    }

    #[test]
    fn the_tightest_limit_counts() {
        let machine = ("proc/meminfo", "MemTotal:  900 kB\nMemAvailable:     500 kB\n");
        assert_eq!(left(&[machine]), Some(500 << 10));
        let two = [
            machine,
            ("proc/self/cgroup", "0::/a/b\n"),
            ("sys/fs/cgroup/a/b/memory.max", "max\n"),
            ("sys/fs/cgroup/a/memory.max", "400000\n"),
            ("sys/fs/cgroup/a/memory.current", "150000\n"),
            ("sys/fs/cgroup/a/memory.stat", "anon 3\ninactive_file 50000\n"),
        ];
        assert_eq!(left(&two), Some(300_000));
        let one = [
            machine,
            ("proc/self/cgroup", "9:cpu:/x\n4:memory:/\n"),
            ("sys/fs/cgroup/memory/memory.limit_in_bytes", "4096"),
            ("sys/fs/cgroup/memory/memory.usage_in_bytes", "5000"),
        ];
        assert_eq!(left(&one), Some(0));
        let own = [
            machine,
            ("proc/self/limits", "Limit  Soft  Hard\nMax address space         200000     unlimited   bytes\n"),
            ("proc/self/status", "VmSize:\t     100 kB\n"),
        ];
        assert_eq!(left(&own), Some(200_000 - 102_400));
        assert_eq!(left(&[]), None);
        assert_eq!(left(&[("proc/meminfo", "MemAvailable: lots\n"), ("proc/self/cgroup", "0\n:::")]), None);
    }

    #[test]
    fn what_fits_is_not_refused() {
        assert_eq!(shortage("this", 1), None);
        if available().is_some() {
            let told = shortage("this run", u64::MAX).unwrap();
            assert!(told.starts_with("this run needs about "), "{told}");
        }
    }
}
