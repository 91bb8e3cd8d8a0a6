//! Decks and meshes that the program carries: for `estar example` and `estar verify`.

macro_rules! shipped {
    ($($path:literal,)*) => { &[$(($path, include_bytes!(concat!("../../../", $path)))),*] };
}

const FILES: &[(&str, &[u8])] = shipped![
    "meshes/taylor/taylor.toml",
    "meshes/taylor/taylor-wall.toml",
    "meshes/taylor/taylor-johnson-cook.toml",
    "meshes/taylor/taylor.msh",
    "meshes/necking/necking.toml",
    "meshes/necking/necking.msh",
    "meshes/cook/cook.toml",
    "meshes/cook/cook.msh",
    "meshes/cook/cook_2.msh",
    "meshes/cook/cook_4.msh",
    "meshes/cook/cook_16.msh",
    "meshes/cook/cook_32.msh",
    "meshes/upset/upset.toml",
    "meshes/upset/upset.msh",
    "meshes/verification/patch.toml",
    "meshes/verification/patch.inp",
    "meshes/verification/free_fall.toml",
    "meshes/verification/spin.toml",
    "meshes/verification/wave.toml",
    "meshes/verification/plastic_wave.toml",
    "meshes/verification/cantilever.toml",
    "meshes/verification/tube.toml",
    "meshes/verification/tube.inp",
    "meshes/point/uniaxial-tension.toml",
    "meshes/point/uniaxial-compression.toml",
    "meshes/point/corotational.toml",
    "meshes/point/convected.toml",
];

/// The content of a file by its place in the repository.
pub fn file(path: &str) -> Option<&'static [u8]> {
    FILES.iter().find(|(known, _)| *known == path).map(|(_, content)| *content)
}

/// All files of a folder of the repository, by their names.
pub fn folder(path: &str) -> impl Iterator<Item = (&'static str, &'static [u8])> {
    FILES.iter().filter_map(move |(known, content)| {
        let (folder, name) = known.rsplit_once('/')?;
        (folder == path).then_some((name, *content))
    })
}
