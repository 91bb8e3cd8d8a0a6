//! Damaged files of every format: an answer, never a panic, an endless loop or memory that the file does not warrant.

mod common;

use std::time::Instant;

use common::{abaqus, gmsh22, gmsh41, sample};
use estar_io::read_mesh_bytes;
use proptest::prelude::*;

fn files() -> Vec<(&'static str, Vec<u8>)> {
    let mesh = sample();
    vec![
        ("Gmsh 4.1, ASCII", gmsh41(&mesh, false)),
        ("Gmsh 4.1, binary", gmsh41(&mesh, true)),
        ("Gmsh 2.2, ASCII", gmsh22(&mesh, false)),
        ("Gmsh 2.2, binary", gmsh22(&mesh, true)),
        ("Abaqus", abaqus(&mesh)),
        ("VTK, ASCII", include_bytes!("corpus/vtk/vtk_42_ascii.vtk").to_vec()),
        ("VTU, ASCII", include_bytes!("corpus/vtk/vtk_ascii_none_32_little.vtu").to_vec()),
        ("VTK, binary", include_bytes!("corpus/vtk/vtk_51_binary.vtk").to_vec()),
        ("VTU, base64, zlib", include_bytes!("corpus/vtk/vtk_binary_zlib_64_little.vtu").to_vec()),
        ("VTU, raw, zlib", include_bytes!("corpus/vtk/vtk_appended_zlib_32_little.vtu").to_vec()),
        ("VTU, base64 behind the XML", include_bytes!("corpus/vtk/vtk_appended_base64_none_64_big.vtu").to_vec()),
    ]
}

#[test]
fn a_file_cut_anywhere_is_an_error_or_a_smaller_mesh() {
    for (name, file) in files() {
        let start = Instant::now();
        for length in 0..file.len() {
            let read = read_mesh_bytes(&file[..length], "cut");
            // Gmsh and XML close every section: nothing short of white space at the end can be missing.
            let whole = file[length..].iter().all(u8::is_ascii_whitespace);
            let is_open = name == "Abaqus" || name.starts_with("VTK");
            assert!(whole || is_open || read.is_err(), "{name}, cut at byte {length}");
        }
        assert!(start.elapsed().as_secs_f64() < 20.0, "{name}");
    }
}

#[test]
fn every_byte_may_be_wrong() {
    for (_, file) in files() {
        let mut damaged = file.clone();
        for at in 0..file.len() {
            for byte in [0, b' ', b'\n', b'-', b'9', b'$', b'*', b',', 0x7f, 0xff, file[at] ^ 1, file[at] ^ 0x80] {
                damaged[at] = byte;
                let _ = read_mesh_bytes(&damaged, "damaged");
            }
            damaged[at] = file[at];
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn several_bytes_may_be_wrong(
        which in 0..11_usize,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12),
    ) {
        let mut file = files().swap_remove(which).1;
        for (at, byte) in changes {
            let at = at.index(file.len());
            file[at] = byte;
        }
        let _ = read_mesh_bytes(&file, "damaged");
    }

    #[test]
    fn pieces_may_be_missing_or_there_twice(
        which in 0..11_usize,
        from in any::<prop::sample::Index>(),
        to in any::<prop::sample::Index>(),
        insert in any::<prop::sample::Index>(),
    ) {
        let file = files().swap_remove(which).1;
        let (a, b) = (from.index(file.len()), to.index(file.len()));
        let piece = &file[a.min(b)..a.max(b)];
        let at = insert.index(file.len());
        let _ = read_mesh_bytes(&[&file[..a.min(b)], &file[a.max(b)..]].concat(), "missing");
        let _ = read_mesh_bytes(&[&file[..at], piece, &file[at..]].concat(), "twice");
    }

    #[test]
    fn anything_may_follow_a_good_start(
        which in 0..11_usize,
        length in any::<prop::sample::Index>(),
        garbage in prop::collection::vec(any::<u8>(), 0..400),
    ) {
        let file = files().swap_remove(which).1;
        let _ = read_mesh_bytes(&[&file[..length.index(file.len())], &garbage].concat(), "garbage");
        let _ = read_mesh_bytes(&garbage, "garbage");
    }

    #[test]
    fn numbers_may_be_of_any_size(
        which in prop::sample::select(vec![0_usize, 2, 4, 5, 6]),
        words in prop::collection::vec((any::<prop::sample::Index>(), any::<u64>()), 1..4),
    ) {
        let text = String::from_utf8(files().swap_remove(which).1).unwrap();
        let mut parts: Vec<String> = text.split_inclusive(char::is_whitespace).map(ToOwned::to_owned).collect();
        for (at, word) in words {
            let at = at.index(parts.len());
            parts[at] = format!("{word} ");
        }
        let _ = read_mesh_bytes(parts.concat().as_bytes(), "numbers");
    }
}
