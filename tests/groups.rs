//! Goal: the name of a group in a deck stands for what its place asks for, and where it could be two things the deck is asked.
//! Meshes: those of `crates/io/tests/corpus`.

use estar_session::Session;
use estar_solver::LaneLevel;
use estar_solver::model::LoadKind;
use std::fs;
use std::path::Path;

/// The session of a mesh of the corpus, all of it one material, with an addition; or what the user is told.
fn session(mesh: &str, part: &str, addition: &str) -> Result<Session, String> {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/io/tests/corpus");
    let folder = tempfile::tempdir().unwrap();
    let deck = format!(
        "[mesh]\nfile = {:?}\n[material.m]\ntheory = \"elastic\"\ndensity = 1000.0\nyoung_modulus = \"1 MPa\"\n\
         poisson_ratio = 0.3\n[[part]]\ngroup = \"{part}\"\nmaterial = \"m\"\nelement = \"hex8-b-bar\"\n\
         [time]\nend = \"1 ms\"\n{addition}",
        corpus.join(mesh)
    );
    let path = folder.path().join("deck.toml");
    fs::write(&path, deck).unwrap();
    Session::load(&path, &[], LaneLevel::best(), &mut ()).map_err(|error| error.to_string())
}

fn told(mesh: &str, part: &str, addition: &str) -> String {
    session(mesh, part, addition).err().expect("the deck was taken")
}

fn hold(group: &str) -> String {
    format!("[[fix]]\ngroup = \"{group}\"\ndirections = [\"x\"]\n")
}

fn held(session: &Session) -> Vec<u64> {
    let problem = session.problem();
    let mut labels: Vec<u64> =
        problem.model.fixes[0].nodes.iter().map(|&node| problem.mesh.node_labels()[node as usize].0).collect();
    labels.sort_unstable();
    labels
}

#[test]
fn a_node_set_is_held_an_element_set_is_a_part_a_surface_is_loaded() {
    let press = "[[pressure]]\ngroup = \"END\"\ncurve = [[0, 0], [1, 1]]\n";
    let session = session("namesakes.inp", "COLUMN", &format!("{}{press}", hold("END"))).unwrap();
    assert_eq!(held(&session), [9, 10]);
    let LoadKind::Pressure { faces, .. } = &session.problem().model.loads[0].kind else { panic!("no pressure") };
    assert_eq!(faces.len(), 1);
    // as a part END is one element of two: the other has no part
    assert!(told("namesakes.inp", "END", "").contains("1 elements belong to no part: 2"));
}

#[test]
fn sets_of_part_and_assembly_are_asked_for_and_told_apart() {
    let both = told("owners.inp", "part.Set-1", &hold("Set-1"));
    assert!(both.contains("2 groups of the mesh are named `Set-1`"), "{both}");
    assert!(both.contains("say `part.Set-1` (node set, 12 nodes) or `assembly.Set-1` (node set, 4 nodes)"), "{both}");
    assert_eq!(held(&session("owners.inp", "part.Set-1", &hold("assembly.Set-1")).unwrap()), [9, 10, 11, 12]);
    assert_eq!(held(&session("owners.inp", "all", &hold("Column-1.Foot")).unwrap()), [1, 2, 3, 4]);
    let part = told("owners.inp", "Set-1", "");
    assert!(part.contains("`part.Set-1` (volume, 2 elements) or `assembly.Set-1` (volume, 1 elements)"), "{part}");
}

#[test]
fn a_surface_and_a_volume_of_one_name_are_told_apart_by_their_kinds() {
    let both = told("same_name.msh", "block", &hold("block"));
    assert!(both.contains("say `volume.block` (volume, 4 nodes) or `surface.block` (surface, 3 nodes)"), "{both}");
}

#[test]
fn a_mesh_without_groups_is_used_by_what_is_always_there() {
    assert_eq!(session("no_sets.inp", "all", "").unwrap().problem().parts[0].element_count, 1);
    let unknown = told("no_groups.msh", "all", &hold("lid"));
    assert!(unknown.contains("`volume_1`, `surface_3`, `surface_4`, `all`"), "{unknown}");
}

#[test]
fn a_group_that_was_left_out_is_told_with_the_reason() {
    let reference = told("reference_point.inp", "all", &hold("REF"));
    assert!(reference.contains("the mesh has no group `REF`"), "{reference}");
    assert!(reference.contains("1 group has only such nodes and is left out: \"REF\""), "{reference}");
    let lid = told("name_without_elements.msh", "all", &hold("lid"));
    assert!(lid.contains("no group is made: surface \"lid\""), "{lid}");
}
