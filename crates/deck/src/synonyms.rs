//! Words of other codes and near misses, each with what there is instead: an unknown name is answered by one sentence where there is one.
//! `docs/coming-from.md` has the same, by code.

/// Where words mean something, the words, and what there is instead.
type Synonyms = (Place, &'static [&'static str], &'static str);

/// A key of a table, or a name that is the value of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// A key of the deck itself.
    Top,
    /// A key of this table.
    KeyOf(&'static str),
    /// A name that is the value of this key.
    NameOf(&'static str),
}

use Place::{KeyOf, NameOf, Top};

const NO_SHELLS: &str = "there are solids only, no shells, membranes, beams, springs or cohesive elements";
const METAL: &str = "a metal that yields by von Mises is theory = \"e-star\" with hardening = { law = ... }: \"perfect\", \"linear\", \
    \"tabulated\" and others";
const NO_POINT_FORCE: &str = "forces act on faces: [[pressure]] along the normal, [[traction]] in a direction, each a force per area; \
    [[gravity]] on every node";

#[rustfmt::skip]
const SYNONYMS: &[Synonyms] = &[
    (Top, &["contact", "contacts", "contact_pair", "general_contact", "interaction", "interactions",
        "contact_automatic"],
     "bodies do not meet each other; rigid tools meet every node: [[rigid_wall]] with shape = \"plane\", \
      \"cylinder\" or \"sphere\""),
    (Top, &["units", "unit", "unit_system"],
     "there is no system of units: numbers are in SI units, a string says its own, such as \"117 GPa\"; a mesh in mm \
      has [mesh] scale = 1e-3"),
    (Top, &["boundary", "boundaries", "bc", "bcs", "spc", "constraint", "constraints", "fixed", "encastre",
        "support", "symmetry"],
     "nodes that are held are [[fix]] with group and directions, nodes that are moved [[prescribed]]"),
    (Top, &["displacement", "displacements", "motion", "prescribed_motion", "impdisp", "impvel",
        "boundary_prescribed_motion"],
     "nodes that are moved are [[prescribed]] with group, direction, quantity and curve"),
    (Top, &["load", "loads", "force", "forces", "cload", "dload", "dsload", "concentrated_force", "nodal_force"],
     NO_POINT_FORCE),
    (Top, &["velocity", "initial", "initial_condition", "initial_conditions", "inivel"],
     "velocities at time 0 are [[initial_velocity]] with group and value"),
    (Top, &["rigid", "rigid_body", "rigidwall", "wall", "tool", "punch", "die", "analytical_surface"],
     "a rigid tool is [[rigid_wall]] with shape = \"plane\", \"cylinder\" or \"sphere\" and, if it moves, motion = { \
      ... }"),
    (Top, &["section", "sections", "solid_section", "property", "properties", "prop"],
     "a [[part]] says which group has which material and element"),
    (Top, &["amplitude", "amplitudes", "curve", "curves", "function", "functions", "table", "define_curve"],
     "a curve stands where it is used: curve = [[time, value], ...]"),
    (Top, &["node", "nodes", "element", "elements", "nset", "elset", "set", "sets", "surface", "group", "groups"],
     "nodes, elements and groups stand in the mesh: [mesh] file = \"...\" of Gmsh (.msh), Abaqus (.inp) or VTK (.vtu)"),
    (Top, &["step", "steps", "solver", "control", "control_termination", "dynamic", "explicit", "run", "simulation",
        "analysis"],
     "the end and the steps are keys of [time]: end, safety_factor and others"),
    (Top, &["history", "field", "fields", "database", "output_request", "anim", "results"],
     "frames and rows of the history are [output], numbers that are followed [[probe]]"),
    (Top, &["tie", "ties", "mpc", "coupling", "rbe2", "rbe3"],
     "parts are joined by nodes that they share: merge them in the mesher"),
    (Top, &["include"],
     "a deck is one file; --set KEY=VALUE replaces a key of it"),
    (Top, &["damping"],
     "damping in proportion to mass is [time] mass_damping; of shocks, bulk_viscosity"),
    (KeyOf("mesh"), &["path", "filename", "name", "mesh", "input"],
     "the mesh is file = \"part.msh\", \"part.inp\" or \"part.vtu\""),
    (KeyOf("mesh"), &["unit", "units", "length_unit"],
     "the length of the file's unit in m is scale: 1e-3 for a mesh in mm"),
    (KeyOf("part"), &["elset", "set", "name", "elements", "region"],
     "the elements are those of a group of the mesh: group = \"...\""),
    (KeyOf("part"), &["elform", "type", "element_type", "formulation", "section", "isolid"],
     "the formulation is element = \"hex8-f-bar\", \"hex8-b-bar\", \"hex8-one-point\", \"hex8\", \"tet4\" or \
      \"tet10\""),
    (KeyOf("part"), &["mat", "mid"],
     "the name of a [material.NAME] stands in material"),
    (KeyOf("material"), &["e", "young", "elastic_modulus", "modulus", "ym"],
     "Young's modulus is young_modulus"),
    (KeyOf("material"), &["nu", "pr", "poisson"],
     "Poisson's ratio is poisson_ratio"),
    (KeyOf("material"), &["rho", "ro", "mass_density"],
     "the mass per volume is density"),
    (KeyOf("material"), &["g", "mu"],
     "the shear modulus is shear_modulus"),
    (KeyOf("material"), &["k"],
     "the bulk modulus is bulk_modulus"),
    (KeyOf("material"), &["type", "model", "law", "mat", "kind"],
     "the kind of material is theory = \"e-star\", \"elastic\" and others"),
    (KeyOf("material"), &["sigy", "yield", "yield_stress", "yield_strength", "sigma_y", "plastic", "plasticity",
        "etan", "tangent_modulus"],
     "the flow stress is hardening = { law = \"linear\", yield_stress = \"400 MPa\", modulus = \"100 MPa\" } or \
      another law"),
    (KeyOf("material"), &["failure", "damage", "erosion", "fail", "eos", "equation_of_state"],
     "there are no failure criteria and no equations of state; [time] on_inversion = \"delete\" takes out elements \
      that turn inside out"),
    (KeyOf("fix"), &["direction", "dof", "dofs", "axes", "axis"],
     "the directions are a list: directions = [\"x\", \"y\"]"),
    (KeyOf("fix"), &["nodes", "set", "nset", "node_set"],
     "the nodes are those of a group of the mesh: group = \"...\""),
    (KeyOf("prescribed"), &["directions", "dof", "axis"],
     "one motion has one direction: direction = \"z\""),
    (KeyOf("prescribed"), &["value", "amplitude", "displacement", "velocity", "points", "function", "lcid"],
     "the motion is quantity = \"displacement\" (or \"velocity\", \"acceleration\") and curve = [[time, value], ...]"),
    (KeyOf("prescribed"), &["kind", "type"],
     "what the curve gives is quantity = \"displacement\", \"velocity\" or \"acceleration\""),
    (KeyOf("pressure"), &["value", "magnitude", "amplitude", "pressure"],
     "a pressure that stays is curve = [[0, \"5 MPa\"]]"),
    (KeyOf("traction"), &["value", "magnitude", "amplitude", "force"],
     "a traction that stays is curve = [[0, \"5 MPa\"]], a force per area"),
    (KeyOf("gravity"), &["value", "g", "direction"],
     "gravity is one vector: acceleration = [0, 0, -9.81]"),
    (KeyOf("rigid_wall"), &["mu", "friction_coefficient", "fric"],
     "Coulomb's coefficient is friction"),
    (KeyOf("rigid_wall"), &["velocity", "displacement", "speed", "curve", "quantity"],
     "a tool moves by motion = { direction = [0, 0, -1], quantity = \"velocity\", curve = [[0, \"1 m/s\"]] }"),
    (KeyOf("rigid_wall"), &["type", "kind", "surface"],
     "the kind of tool is shape = \"plane\", \"cylinder\" or \"sphere\""),
    (KeyOf("time"), &["endtim", "endtime", "end_time", "tend", "t_end", "duration", "termination", "period"],
     "the time at which a run ends is end"),
    (KeyOf("time"), &["tssfac", "cfl", "courant", "scale_factor", "dtfac"],
     "the fraction of the stable step is safety_factor"),
    (KeyOf("time"), &["dt2ms", "dtmin_mass"],
     "mass that is added for a longer step is mass_scaling = { target_time_step = \"1e-8 s\" }"),
    (KeyOf("time"), &["dt", "step", "increment", "dt_max", "time_increment"],
     "steps are chosen from the mesh and cannot be given: safety_factor makes them shorter, mass_scaling longer"),
    (KeyOf("time"), &["alpha", "damping", "rayleigh"],
     "damping in proportion to mass is mass_damping, in 1/s"),
    (KeyOf("output"), &["interval", "dt", "time_interval", "period"],
     "frames are counted by frames or come with a time between them, every"),
    (KeyOf("probe"), &["type"],
     "what is followed is kind = \"reaction\", \"node\", \"group-average\" and others"),
    (NameOf("element"), &["c3d8r", "elform1", "underintegrated", "isolid1", "isolid24", "heph", "hex8r", "brick"],
     "a hex with one point is element = \"hex8-one-point\", with hourglass = \"physical\", \"stiffness\" or \
      \"viscous\""),
    (NameOf("element"), &["c3d8", "c3d8h", "elform2", "isolid14", "isolid17", "ha8", "hex", "hexahedron", "solid",
        "hex8bbar", "hex8fbar", "bbar", "fbar"],
     "a fully integrated hex that does not lock in metals is \"hex8-f-bar\" (what hexes have unless another is \
      given) or \"hex8-b-bar\""),
    (NameOf("element"), &["c3d8i"],
     "there are no incompatible modes: in bending \"hex8-one-point\" with hourglass = \"physical\" comes nearest"),
    (NameOf("element"), &["c3d4", "c3d4h", "elform10", "elform13", "tetra", "tet", "tetra4", "tetrahedron"],
     "a tet of four nodes is \"tet4\""),
    (NameOf("element"), &["c3d10", "c3d10m", "c3d10h", "c3d10hs", "elform16", "elform17", "tetra10", "tet10m"],
     "a tet of ten nodes is \"tet10\""),
    (NameOf("element"), &["c3d6", "c3d6r", "c3d5", "elform15", "penta6", "wedge", "wedge6", "pyramid"],
     "wedges and pyramids are \"hex8-b-bar\", \"hex8-one-point\" or \"hex8\""),
    (NameOf("element"), &["c3d20", "c3d20r", "c3d27", "c3d15", "hex20", "hex27", "brick20"],
     "hexes and wedges of second order are not there: mesh with hexes of eight nodes, or tets of ten (\"tet10\")"),
    (NameOf("element"), &["s4", "s4r", "s3", "s3r", "sc8r", "m3d4", "b31", "t3d2", "shell", "belytschkotsay", "beam",
        "truss", "coh3d8", "cohesive", "cps4r", "cpe4r", "cax4r"],
     NO_SHELLS),
    (NameOf("theory"), &["johnsoncook", "mat15", "matjohnsoncook", "law2", "plasjohns"],
     "Johnson-Cook is a law of hardening: theory = \"e-star\" with hardening = { law = \"johnson-cook\", ... }"),
    (NameOf("theory"), &["mat24", "matpiecewiselinearplasticity", "piecewiselinearplasticity", "law36", "plastab",
        "multilinear", "tabulated"],
     "a curve of flow stress is theory = \"e-star\" with hardening = { law = \"tabulated\", points = [[0, \"400 \
      MPa\"], ...] }"),
    (NameOf("theory"), &["mat3", "matplastickinematic", "plastickinematic", "bilinear"],
     "linear hardening is theory = \"e-star\" with hardening = { law = \"linear\", ... }; kinematic = { law = \
      \"prager\", ... } moves the surface"),
    (NameOf("theory"), &["mat18", "powerlaw", "matpowerlawplasticity", "ludwik", "swift", "voce", "perfect",
        "linear"],
     "laws of hardening stand under a theory: theory = \"e-star\" with hardening = { law = \"swift\", \"ludwik\", \
      \"voce\" or another, ... }"),
    (NameOf("theory"), &["j2", "vonmises", "mises", "plastic", "plasticity", "elastoplastic", "elasticplastic",
        "metal", "isotropic", "steel"],
     METAL),
    (NameOf("theory"), &["mat1", "matelastic", "law1", "linearelastic", "hooke", "hypoelastic", "isotropicelastic"],
     "a material without yielding is theory = \"elastic\""),
    (NameOf("theory"), &["neohooke", "neohookean", "mooneyrivlin", "ogden", "hyperelastic", "yeoh", "arrudaboyce",
        "mat27", "mat77", "law42", "law69"],
     "there are no laws of rubber; theory = \"hencky\" is hyperelastic, with a logarithmic strain, and yields only \
      where it has hardening"),
    (NameOf("theory"), &["mat20", "matrigid", "rigid"],
     "a rigid tool is no material: [[rigid_wall]] with shape = \"plane\", \"cylinder\" or \"sphere\""),
    (NameOf("theory"), &["druckerprager", "mohrcoulomb", "rankine", "mat193", "mat173", "law10", "law21", "soil",
        "concrete"],
     "these are yield surfaces: theory = \"hencky\" with yield_surface = { kind = \"drucker-prager\", \
      \"mohr-coulomb\" or \"rankine\", ... }"),
    (NameOf("theory"), &["crushablefoam", "foam", "mat63", "gurson", "gtn", "composite", "orthotropic", "hill",
        "mat54", "mat57", "viscoelastic", "mat6", "acoustic", "gas"],
     "there is no such material: isotropic elasticity and plasticity are there, see `docs/theories.md`"),
    (NameOf("law"), &["isotropic", "bilinear"],
     "linear hardening is law = \"linear\" with yield_stress and modulus"),
    (NameOf("law"), &["table", "multilinear", "piecewiselinear", "curve", "points", "tabular"],
     "a table is law = \"tabulated\" with points = [[strain, stress], ...] or file = \"...csv\""),
    (NameOf("law"), &["power", "powerlaw", "hollomon", "rambergosgood"],
     "powers of the strain are law = \"ludwik\" and \"swift\""),
    (NameOf("law"), &["kinematic", "chaboche", "combined"],
     "hardening that moves the surface is kinematic = { law = \"prager\" or \"armstrong-frederick\", ... } of the \
      material"),
    (NameOf("law"), &["none", "perfectlyplastic", "idealplastic"],
     "a flow stress that stays is law = \"perfect\""),
    (NameOf("interpolation"), &["smoothstep", "sstep", "cosine", "ramp"],
     "a start and an end at rest are \"smooth\" (at rest at every point) or \"monotone\" (only at the first and the \
      last)"),
    (NameOf("interpolation"), &["cubic", "spline", "pchip"],
     "a curve without kinks is \"monotone\""),
    (NameOf("interpolation"), &["tabular", "piecewise", "piecewiselinear", "equallyspaced", "step", "constant"],
     "straight lines are \"linear\""),
    (NameOf("kind"), &["force", "rf", "spcforc", "reactionforce"],
     "the force on nodes that are held or driven is \"reaction\", that of a tool \"contact-force\""),
    (NameOf("kind"), &["rcforc", "rwforc", "contact"],
     "the force of a rigid tool is \"contact-force\""),
    (NameOf("kind"), &["displacement", "velocity", "stress", "strain", "nodout"],
     "a field is followed at a \"node\" or an \"element\", or as \"group-average\" or \"maximum\", with field = \
      \"...\""),
    (NameOf("kind"), &["energy", "glstat", "matsum"],
     "energies are columns of history.csv already"),
    (NameOf("kind"), &["mises"],
     "von Mises' surface is \"von-mises\""),
    (NameOf("field"), &["u", "disp"],
     "displacements are \"displacement\""),
    (NameOf("field"), &["s", "stress", "sigma"],
     "stresses are \"cauchy_stress\", \"von_mises_stress\" and \"pressure\""),
    (NameOf("field"), &["peeq", "plasticstrain", "epsp", "effectiveplasticstrain"],
     "the equivalent plastic strain is \"equivalent_plastic_strain\""),
    (NameOf("field"), &["mises", "vonmises"],
     "von Mises' stress is \"von_mises_stress\""),
];

/// What there is instead of a key that a table at `place`, such as `material.copper`, does not have.
pub fn of_key(place: &str, key: &str) -> Option<&'static str> {
    let table = match place.split_once('.') {
        // the tables of [material.NAME] have keys of their own
        Some(("material", name)) if !name.contains('.') => "material",
        Some(_) => return None,
        None => place,
    };
    find(&key.to_lowercase().replace(['-', ' '], "_"), |other| match other {
        Top => table.is_empty(),
        KeyOf(owner) => owner == table,
        NameOf(_) => false,
    })
}

/// What there is instead of a name that the key at the end of `place` cannot have.
pub fn of_name(place: &str, name: &str) -> Option<&'static str> {
    let key = place.rsplit('.').next().unwrap_or(place);
    let bare: String = name.to_lowercase().chars().filter(char::is_ascii_alphanumeric).collect();
    // MAT_024 is MAT_24
    let digits = bare.find(|c: char| c.is_ascii_digit()).unwrap_or(bare.len());
    let (word, number) = bare.split_at(digits);
    let short = format!("{word}{}", number.trim_start_matches('0'));
    let is_name = |other: Place| matches!(other, NameOf(owner) if owner == key);
    find(&bare, is_name).or_else(|| find(&short, is_name))
}

fn find(word: &str, is_place: impl Fn(Place) -> bool) -> Option<&'static str> {
    let mut rows = SYNONYMS.iter().filter(|(place, ..)| is_place(*place));
    rows.find(|(_, words, _)| words.contains(&word)).map(|(.., instead)| *instead)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_is_written_as_it_is_looked_up_and_stands_once() {
        for (index, (place, words, instead)) in SYNONYMS.iter().enumerate() {
            assert!(!instead.ends_with('.'), "{instead}");
            for word in *words {
                let found = match place {
                    Top => of_key("", word),
                    KeyOf("material") => of_key("material.steel", word),
                    KeyOf(table) => of_key(table, word),
                    NameOf(key) => of_name(&format!("table.{key}"), word),
                };
                assert_eq!(found, Some(*instead), "{word}");
                let before = SYNONYMS[..index].iter().filter(|(other, ..)| other == place);
                assert!(!before.into_iter().any(|(_, words, _)| words.contains(word)), "{word} twice");
            }
        }
    }

    #[test]
    fn spelling_of_other_codes_does_not_matter() {
        for name in ["MAT_024", "mat24", "*MAT_PIECEWISE_LINEAR_PLASTICITY", "Mat-24"] {
            assert!(
                of_name("material.steel.theory", name).is_some_and(|instead| instead.contains("tabulated")),
                "{name}"
            );
        }
        assert_eq!(of_name("material.steel.theory", "unheard-of"), None);
        assert_eq!(of_key("time.quasi_static", "contact"), None);
    }
}
