//! The memory that a run takes and the memory that there is: a run that does not fit is refused before it begins, not killed
//! by the system in the middle.

use crate::format::bytes;
use estar_mesh::Shape;
use std::fs;
use std::path::Path;

/// While a mesh is read, its file and what is made of it are in memory, and it again in another order: 2.0 times the file for hexes
/// and ten-node tets, 2.4 for four-node tets, were measured without the last.
const BYTES_PER_BYTE_OF_MESH: u64 = 3;
/// A deck is a tree of values with their places: measured for lists, keys and tables, all as short as they can be, 78 to 168.
const BYTES_PER_BYTE_OF_DECK: u64 = 180;
/// The text of a table and its numbers.
const BYTES_PER_BYTE_OF_TABLE: u64 = 2;

/// What can be done about a shortage.
pub const HELP: &str = "take a coarser mesh or a machine with more memory, or end other programs";

/// Why the mesh of a file cannot be read, if it does not fit.
pub fn shortage_of_mesh(path: &Path) -> Option<String> {
    shortage_of_file(path, BYTES_PER_BYTE_OF_MESH)
}

/// Bytes that a mesh may have with all the files that it includes, so that reading it fits.
pub fn most_of_mesh() -> u64 {
    available().map_or(u64::MAX, |available| available / BYTES_PER_BYTE_OF_MESH)
}

/// Why the table of a file cannot be read, if it does not fit.
pub fn shortage_of_table(path: &Path) -> Option<String> {
    shortage_of_file(path, BYTES_PER_BYTE_OF_TABLE)
}

/// Why the deck of a file cannot be read, if it does not fit.
pub fn shortage_of_text(path: &Path) -> Option<String> {
    shortage_of_file(path, BYTES_PER_BYTE_OF_DECK)
}

fn shortage_of_file(path: &Path, factor: u64) -> Option<String> {
    // a file that cannot be looked at is told of when it is read
    let size = fs::metadata(path).map_or(0, |metadata| metadata.len());
    shortage(&format!("reading {}", path.display()), size.saturating_mul(factor))
}

/// How large a structured mesh is going to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshSize {
    /// Hexes, before they are cut.
    pub hexes: u64,
    /// Their faces on the outside.
    pub outer_faces: u64,
}

impl MeshSize {
    /// That of a box with so many cells along each axis.
    pub fn of_box(cells: [u32; 3]) -> Self {
        let [x, y, z] = cells.map(u64::from);
        Self { hexes: x * y * z, outer_faces: 2 * (x * y + y * z + z * x) }
    }

    /// That of a round bar: in section a quarter has c² + 2 c r quads, c + r edges on either plane of symmetry and 2 c on the circle.
    pub fn of_round_bar(is_full: bool, core_cells: u32, rings: u32, axial_cells: u32) -> Self {
        let [core, rings, axial] = [core_cells, rings, axial_cells].map(u64::from);
        let (quarters, planes) = if is_full { (4, 0) } else { (1, 2) };
        let quads = quarters * (core * core + 2 * core * rings);
        let edges = planes * (core + rings) + quarters * 2 * core;
        Self { hexes: quads * axial, outer_faces: 2 * quads + edges * axial }
    }
}

/// Bytes that it takes to make and to write a structured mesh of so many hexes and outer faces, whose hexes are cut into a shape.
///
/// Measured for boxes of one cell to 300,000 along each axis and for cylinders: these are 4 to 26 % more than was taken.
pub fn of_new_mesh(size: MeshSize, shape: Shape) -> u64 {
    let (per_hex, per_face) = match shape {
        Shape::Hex8 | Shape::Pyramid5 => (230, 130),
        Shape::Wedge6 => (430, 200),
        Shape::Tet4 => (890, 190),
        Shape::Tet10 => (1750, 360),
    };
    size.hexes.saturating_mul(per_hex).saturating_add(size.outer_faces.saturating_mul(per_face))
}

/// Why such a mesh cannot be made, if it does not fit.
pub fn shortage_of_new_mesh(size: MeshSize, shape: Shape) -> Option<String> {
    shortage("this mesh", of_new_mesh(size, shape))
}

/// Why something that takes so many bytes cannot be done, if it does not fit.
pub fn shortage(what: &str, needed: u64) -> Option<String> {
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
    fn the_size_of_a_mesh_is_known_before() {
        use estar_mesh::Mesh;
        use estar_mesh::generate::{BoxSpec, CylinderParameters, Section, box_mesh, cylinder};
        let made = |mesh: &Mesh| {
            let outer_faces = mesh.groups().iter().map(|group| group.faces.len() as u64).sum();
            MeshSize { hexes: mesh.element_count() as u64, outer_faces }
        };
        let cells = [2, 3, 5];
        assert_eq!(MeshSize::of_box(cells), made(&box_mesh(&BoxSpec::new([1.0; 3], cells).unwrap())));
        for section in [Section::Quarter, Section::Full] {
            for (core_cells, radial_rings, axial_cells) in [(1, 1, 1), (3, 2, 4), (2, 5, 3)] {
                let bar = CylinderParameters {
                    radius: 1.0,
                    length: 2.0,
                    section,
                    core_cells,
                    radial_rings,
                    axial_cells,
                    axial_grading: 1.0,
                };
                let told = MeshSize::of_round_bar(section == Section::Full, core_cells, radial_rings, axial_cells);
                assert_eq!(told, made(&cylinder(&bar.try_into().unwrap())));
            }
        }
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
