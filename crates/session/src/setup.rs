//! From deck and mesh to a problem that can be run.

use crate::bodies::{self, Bodies};
use crate::conformity;
use crate::constraints;
use crate::error::SessionError;
use crate::expectations;
use crate::output::output_plan;
use crate::plausibility;
use crate::probes;
use crate::problem::{PartDescription, Problem};
use crate::problem_memory;
use crate::quasi_static::{self, QuasiStatic};
use crate::tools;
use crate::trouble;
use estar_deck::decoder::{At, Decoder, GroupMention};
use estar_deck::diagnostics::{Diagnostic, Diagnostics, Findings, Span, listed, nearest};
use estar_deck::fields::Field;
use estar_deck::format::{hex, short};
use estar_deck::memory;
use estar_deck::names::{GroupName, OfFaces, OfNodes};
use estar_deck::source::read_text;
use estar_deck::values::{Length, Positive, Quantity};
use estar_deck::{self as deck, Deck, Reading};
use estar_io::MeshFile;
use estar_material::MaterialModel;
use estar_mesh::conformity::Conformity;
use estar_mesh::quality::{QualityReport, QualitySummary, volume};
use estar_mesh::{Connectivity, Group, GroupError, Mesh, Wanted, locality_order};
use estar_solver::model::{
    BulkViscosity, Fix, Formulation, InitialVelocity, Load, LoadKind, MassScaling, Model, Part, Prescribed, Spin,
    TimeSettings,
};
use estar_solver::{LaneLevel, Simulation};
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// Reads the deck at `deck_path` and its mesh.
///
/// # Errors
/// The deck cannot be read, or every fault of deck and mesh.
pub fn load(deck_path: &Path, overrides: &[String]) -> Result<Problem, SessionError> {
    let text = read_text(deck_path).map_err(SessionError::Deck)?;
    let Reading { sources, deck, decoder } = deck::read(deck_path, &text, overrides);
    let Decoder { diagnostics, groups, mesh_file, texts, unreadable_count, .. } = decoder;
    let mut findings = Findings { sources, diagnostics };
    let diagnostics = &mut findings.diagnostics;
    let fault = |findings: Findings, is_unreadable_file: bool| {
        let only_files = unreadable_count > 0 && findings.diagnostics.error_count() == unreadable_count;
        Err(SessionError::Faults { is_unreadable_file: is_unreadable_file || only_files, findings })
    };

    let scale = deck.as_ref().map_or(1.0, |deck| deck.mesh.scale.value);
    let merge = deck.as_ref().and_then(|deck| deck.mesh.merge);
    let Some(mesh_file) = mesh_file else { return fault(findings, false) };
    if let Some(shortage) = memory::shortage_of_mesh(&mesh_file.value) {
        diagnostics.push(Diagnostic::error(shortage).at(mesh_file.span, "this mesh").help(memory::HELP));
        return fault(findings, false);
    }
    let content = match estar_io::read_mesh_within(&mesh_file.value, memory::most_of_mesh()) {
        Ok(content) => content,
        Err(error) => {
            let is_unreadable_file = error.is_unreadable() && !diagnostics.has_errors();
            diagnostics.push(Diagnostic::error(error.to_string()).at(mesh_file.span, "this mesh"));
            return fault(findings, is_unreadable_file);
        }
    };
    let Some(ReadMesh { mesh, quality, format, merged }) = in_metres(content, &mesh_file, scale, merge, diagnostics)
    else {
        return fault(findings, false);
    };
    check_groups(&mesh, &groups, diagnostics);
    let Some(deck) = deck.filter(|_| !diagnostics.has_errors()) else { return fault(findings, false) };

    let model = model(&deck, &mesh, diagnostics);
    quasi_static::check(&deck, diagnostics);
    constraints::check(&deck, &mesh, diagnostics);
    let connectivity = Connectivity::new(&mesh);
    tools::check(&deck, &mesh, &connectivity, &model, diagnostics);
    let probes = probes::resolve(&deck, &mesh, &model.parts, diagnostics);
    let expectations = expectations::resolve(&deck, diagnostics);
    let output = output_plan(&deck, diagnostics);
    check_temperature(&deck, &model.parts, diagnostics);
    if diagnostics.has_errors() {
        return fault(findings, false);
    }
    doubt(&deck, &mesh, &model, &connectivity, mesh_file.span, diagnostics);
    let wanted = deck.time.quasi_static.clone();
    let driven = constraints::driven(&deck);
    let mut problem = Problem {
        parts: describe_parts(&deck, &mesh),
        wall_names: tools::names(&deck),
        title: deck.title,
        deck_path: deck_path.to_owned(),
        deck_hash: deck_hash(&text, &texts, overrides),
        mesh_path: mesh_file.value,
        mesh_format: format,
        quality,
        merged,
        connectivity,
        mesh,
        model,
        quasi_static: None,
        driven,
        probes,
        expectations,
        output,
        findings,
    };
    // a problem that does not fit into memory is refused before it is run
    if let Some(wanted) = wanted.filter(|_| problem_memory::shortage(&problem).is_none()) {
        let Problem { mesh, model, findings, .. } = &mut problem;
        let Some(chosen) = QuasiStatic::of(&wanted, mesh, model, &mut findings.diagnostics) else {
            return fault(problem.findings, false);
        };
        model.settings.mass_damping = chosen.mass_damping;
        model.settings.mass_scaling.get_or_insert(UNSCALED).factor = chosen.mass_factor;
        problem.quasi_static = Some(chosen);
    }
    Ok(problem)
}

/// The problem at time 0, ready to run.
///
/// # Errors
/// What the solver refuses, a time step so small that time could never reach the end, or too little memory.
pub fn simulation(problem: &Problem, lanes: LaneLevel) -> Result<Simulation, SessionError> {
    if let Some(shortage) = problem_memory::shortage(problem) {
        return Err(SessionError::NoMemory { shortage });
    }
    let simulation = Simulation::new(&problem.mesh, problem.model.clone(), lanes)
        .map_err(|error| SessionError::Model { told: trouble::of_model(&error, problem), error })?;
    let mass_factor = problem.quasi_static.map_or(1.0, |chosen| chosen.mass_factor);
    let jumps = constraints::jumps(&problem.driven, &problem.model, mass_factor, simulation.time_step());
    if jumps.has_errors() {
        let findings = Findings { sources: problem.findings.sources.clone(), diagnostics: jumps };
        return Err(SessionError::Faults { findings, is_unreadable_file: false });
    }
    let end = simulation.end_time();
    // near the end, t + Δt must differ from t
    if end + simulation.time_step() > end {
        Ok(simulation)
    } else {
        Err(SessionError::Standstill { told: trouble::of_standstill(problem, &simulation) })
    }
}

/// That of the deck, of the files that it names beside the mesh, and of the overrides.
fn deck_hash(text: &str, texts: &[String], overrides: &[String]) -> String {
    let mut hasher = Sha256::new();
    hasher.update(text.as_bytes());
    for argument in texts.iter().chain(overrides) {
        hasher.update(b"\0");
        hasher.update(argument.as_bytes());
    }
    hex(&hasher.finalize())
}

/// A mesh that has been read.
struct ReadMesh {
    /// In m and in good order.
    mesh: Mesh,
    quality: QualitySummary,
    format: String,
    /// What was merged, in words.
    merged: Option<String>,
}

/// The mesh in m; faults are reported at the deck's mention of the file.
fn in_metres(
    content: MeshFile,
    file: &At<PathBuf>,
    scale: f64,
    merge: Option<At<Quantity<Positive<Length>>>>,
    diagnostics: &mut Diagnostics,
) -> Option<ReadMesh> {
    const MOST_SHOWN: usize = 10;
    let MeshFile { mesh, format, warnings } = content;
    for warning in warnings {
        diagnostics.push(Diagnostic::warning(warning).at(file.span, "this mesh"));
    }
    let mesh = match mesh.scaled(scale) {
        Ok(mesh) => mesh,
        Err(error) => {
            diagnostics.push(Diagnostic::error(format!("the mesh, scaled: {error}")).at(file.span, "this mesh"));
            return None;
        }
    };
    let (mesh, merged) = match merge {
        Some(tolerance) => merged(&mesh, &tolerance, diagnostics)?,
        None => (mesh, None),
    };
    let quality = QualityReport::new(&mesh);
    for error in quality.errors().iter().take(MOST_SHOWN) {
        diagnostics.push(Diagnostic::error(format!("the mesh: {error}")).at(file.span, "this mesh"));
    }
    if quality.errors().len() > MOST_SHOWN {
        let more = format!("the mesh has {} more such faults", quality.errors().len() - MOST_SHOWN);
        diagnostics.push(Diagnostic::error(more).at(file.span, "this mesh").help("`estar mesh info` shows more"));
    }
    let order = locality_order(&mesh);
    Some(ReadMesh { mesh: mesh.renumbered(&order), quality: quality.summary(), format, merged })
}

/// The mesh without the nodes that `[mesh] merge` makes one, and what became of them.
fn merged(
    mesh: &Mesh,
    tolerance: &At<Quantity<Positive<Length>>>,
    diagnostics: &mut Diagnostics,
) -> Option<(Mesh, Option<String>)> {
    let merged = match mesh.merged(tolerance.value.value) {
        Ok(merged) => merged,
        Err(error) => {
            let diagnostic = Diagnostic::error(error.to_string()).at(tolerance.span, "this tolerance");
            diagnostics.push(diagnostic.help("a tolerance far below the shortest edge, such as \"1e-6 mm\""));
            return None;
        }
    };
    if merged.node_count == 0 {
        let message = format!("`mesh.merge`: no two nodes are within {:e} m of each other", tolerance.value.value);
        diagnostics.push(Diagnostic::warning(message).at(tolerance.span, "nothing is merged"));
    }
    let words =
        format!("{} nodes joined to others, {} m away at most", merged.node_count, short(merged.largest_distance));
    Some((merged.mesh, Some(words)))
}

/// What is probably not meant, though it can be computed.
fn doubt(
    deck: &Deck,
    mesh: &Mesh,
    model: &Model,
    connectivity: &Connectivity,
    mesh_span: Span,
    diagnostics: &mut Diagnostics,
) {
    plausibility::check_sizes(deck, mesh, &model.parts, mesh_span, diagnostics);
    let names = deck.part.iter().map(|part| part.group.name.value.as_str());
    let bodies = Bodies::new(connectivity, model.parts.iter().map(|part| &part.elements[..]), names);
    let of_mesh = conformity::doubts(&Conformity::new(mesh, connectivity), "m");
    for doubt in of_mesh.into_iter().chain(bodies::doubts(mesh, &bodies, model)) {
        diagnostics.push(Diagnostic::warning(doubt.message).at(mesh_span, "this mesh").help(doubt.help));
    }
}

/// Every group that the deck mentions must be in the mesh and have what is wanted of it.
fn check_groups(mesh: &Mesh, mentions: &[GroupMention], diagnostics: &mut Diagnostics) {
    for GroupMention { name, wanted } in mentions {
        let diagnostic = match mesh.find(&name.value, *wanted) {
            Ok(_) => continue,
            Err(GroupError::OtherKind(group)) => {
                let (kind, kinds) = (group.kind, wanted.kinds());
                let message = format!("the group `{}` is a {kind}, but a {kinds} is needed", name.value);
                Diagnostic::error(message).at(name.span, format!("a {kind}"))
            }
            Err(GroupError::Ambiguous(groups)) => {
                let full = groups.iter().map(|group| {
                    let (count, what) = match wanted {
                        Wanted::Elements => (group.elements.len(), "elements"),
                        Wanted::Faces => (group.faces.len(), "faces"),
                        Wanted::Nodes => (group.nodes.len(), "nodes"),
                    };
                    format!("`{}` ({}, {count} {what})", mesh.name_to_find(group, *wanted), group.kind)
                });
                let full = full.collect::<Vec<_>>().join(" or ");
                let message = format!("{} groups of the mesh are named `{}`", groups.len(), name.value);
                let diagnostic = Diagnostic::error(message).at(name.span, "which of them?");
                diagnostics.push(diagnostic.help(format!("say {full}")));
                continue;
            }
            Err(GroupError::Unknown) => {
                let fitting = mesh.groups().iter().filter(|group| wanted.is_had_by(group.kind));
                let label = match nearest(&name.value, fitting.map(|group| group.name.as_str())) {
                    Some(similar) => format!("did you mean \"{similar}\"?"),
                    None => "unknown".to_owned(),
                };
                Diagnostic::error(format!("the mesh has no group `{}`", name.value)).at(name.span, label)
            }
        };
        let help = match listed(mesh.names_to_find(*wanted).iter().map(String::as_str)) {
            none if none.is_empty() => "the mesh has no group that would serve".to_owned(),
            names => format!("the groups that would serve are {names}"),
        };
        diagnostics.push(diagnostic.help(help));
    }
}

/// A field of temperatures is asked for only where a material has one.
fn check_temperature(deck: &Deck, parts: &[Part], diagnostics: &mut Diagnostics) {
    if let Some(field) = deck.output.fields.iter().find(|field| field.value == Field::Temperature)
        && !parts.iter().any(|part| part.material.has_temperature())
    {
        let diagnostic = Diagnostic::error("`output.fields` has the temperature, but no material has one");
        let help = "a material has a temperature with hardening = { law = \"johnson-cook\", ... }";
        diagnostics.push(diagnostic.at(field.span, "this field").help(help));
    }
}

/// Largest kinetic energy of added mass where the deck names none, as a share of the largest energy in play.
const KINETIC_LIMIT: f64 = 0.1;

/// Mass scaling that does nothing yet; of a quasi-static process the kinetic energy is reported, not limited.
const UNSCALED: MassScaling = MassScaling { factor: 1.0, target_time_step: 0.0, limit: 0.0, kinetic_limit: f64::MAX };

/// What the solver is given.
fn model(deck: &Deck, mesh: &Mesh, diagnostics: &mut Diagnostics) -> Model {
    let nodes = |group: &GroupName<OfNodes>| group.nodes(mesh).unwrap_or_default();
    Model {
        parts: parts(deck, mesh, diagnostics),
        fixes: deck
            .fix
            .iter()
            .map(|fix| Fix {
                nodes: nodes(&fix.group),
                directions: fix.directions.iter().map(|direction| direction.value).collect(),
            })
            .collect(),
        prescribed: deck
            .prescribed
            .iter()
            .filter_map(|entry| {
                Some(Prescribed {
                    nodes: nodes(&entry.group),
                    direction: entry.direction.value,
                    quantity: entry.motion.quantity(),
                    curve: entry.motion.curve(deck.interpolation(entry.interpolation))?,
                })
            })
            .collect(),
        initial_velocities: initial_velocities(deck, mesh, diagnostics),
        loads: loads(deck, mesh, diagnostics),
        walls: tools::walls(deck),
        settings: TimeSettings {
            end: deck.time.end.value,
            safety_factor: deck.time.safety_factor.value,
            time_step: deck.time.time_step(diagnostics),
            bulk_viscosity: deck.time.bulk_viscosity.as_ref().map(|viscosity| BulkViscosity {
                linear: viscosity.linear.value,
                quadratic: viscosity.quadratic.value,
            }),
            energy_error_limit: deck.time.energy_error_limit.value,
            on_inversion: deck.time.on_inversion,
            max_steps: deck.time.max_steps.map(|count| count.0),
            min_time_step: deck.time.min_time_step.map(|step| step.value),
            mass_scaling: deck.time.mass_scaling.as_ref().map(|scaling| MassScaling {
                factor: scaling.factor.value.value,
                target_time_step: scaling.target_time_step.map_or(0.0, |step| step.value),
                limit: scaling.limit.value,
                kinetic_limit: match (&scaling.kinetic_limit, &deck.time.quasi_static) {
                    (Some(limit), _) => limit.value,
                    (None, Some(_)) => UNSCALED.kinetic_limit,
                    (None, None) => KINETIC_LIMIT,
                },
            }),
            mass_damping: deck.time.mass_damping.value,
        },
    }
}

fn parts(deck: &Deck, mesh: &Mesh, diagnostics: &mut Diagnostics) -> Vec<Part> {
    let materials = &deck.material.0;
    let parts = deck.part.iter().filter_map(|part| {
        let (_, material) = materials.iter().find(|(name, _)| *name == part.material.0.value)?;
        if let Some(reason) = material.obstacle_to_elements() {
            let message = format!("the material `{}` is for `estar point` only", part.material.0.value);
            diagnostics
                .push(Diagnostic::error(message).at(part.material.0.span, "no element can have it").help(reason));
        }
        let elements = &part.group.group(mesh)?.elements;
        let element = part.formulation(mesh, elements, material, diagnostics);
        if element == Formulation::FBar && !material.keeps_volume() {
            let message = "plastic flow that changes the volume, in elements `hex8-f-bar`, does not keep the energy";
            let help = "take element = \"hex8-b-bar\", the default for such a material";
            diagnostics.push(Diagnostic::warning(message).at(part.material.0.span, "this material").help(help));
        }
        if element == Formulation::Full && matches!(material, MaterialModel::HenckyClosestPoint(_)) {
            let message =
                "elements `hex8` lock where flow constrains the volume, by dilatancy too: the forces become too large";
            let help = "take element = \"hex8-b-bar\"; or tets of ten nodes, which are the softest";
            diagnostics.push(Diagnostic::warning(message).at(part.material.0.span, "this material").help(help));
        }
        Some(Part { elements: elements.clone(), material: material.clone(), element })
    });
    let parts: Vec<Part> = parts.collect();

    for (name, _) in materials {
        if !deck.part.iter().any(|part| part.material.0.value == *name) {
            diagnostics.push(Diagnostic::warning(format!("the material `{name}` is used by no part")));
        }
    }
    const NOBODY: usize = usize::MAX;
    let mut owners = vec![NOBODY; mesh.element_count()];
    for (index, part) in parts.iter().enumerate() {
        let mut rivals: Vec<(usize, usize, u32)> = Vec::new();
        for element in &part.elements {
            match owners[*element as usize] {
                NOBODY => owners[*element as usize] = index,
                rival => match rivals.iter_mut().find(|(known, ..)| *known == rival) {
                    Some((_, count, _)) => *count += 1,
                    None => rivals.push((rival, 1, *element)),
                },
            }
        }
        for (rival, count, element) in rivals {
            let label = mesh.element_labels()[element as usize].0;
            let message = format!("{count} elements are in two parts, among them element {label}");
            let diagnostic = Diagnostic::error(message).at(deck.part[index].group.name.span, "the second part");
            let diagnostic = diagnostic.at(deck.part[rival].group.name.span, "the first part");
            diagnostics.push(diagnostic.help("every element belongs to exactly one part"));
        }
    }
    let orphans: Vec<usize> = (0..owners.len()).filter(|element| owners[*element] == NOBODY).collect();
    if let Some(first) = orphans.first() {
        let named = orphans.iter().take(5).map(|element| mesh.element_labels()[*element].0.to_string());
        let dots = if orphans.len() > 5 { ", ..." } else { "" };
        let labels = named.collect::<Vec<_>>().join(", ");
        let message = format!("{} elements belong to no part: {labels}{dots}", orphans.len());
        // but for the group of all elements, which would take those of the other parts
        let is_owner = |group: &Group| {
            let has_others = group.name == "all" && orphans.len() < owners.len();
            !has_others && group.elements.binary_search(&(*first as u32)).is_ok()
        };
        let names = mesh.full_names();
        let of_orphans = mesh.groups().iter().zip(&names).filter(|(group, _)| is_owner(group));
        let groups = listed(of_orphans.map(|(_, name)| name.as_str()));
        let help = match groups.as_str() {
            "" => "no volume group but `all` has them: give them one in the mesher".to_owned(),
            groups => format!("they are in the volume group {groups}: it needs a [[part]]"),
        };
        let mut diagnostic = Diagnostic::error(message);
        if let Some(part) = deck.part.first() {
            diagnostic = diagnostic.at(part.span, "the parts begin here");
        }
        diagnostics.push(diagnostic.help(help));
    }
    parts
}

fn initial_velocities(deck: &Deck, mesh: &Mesh, diagnostics: &mut Diagnostics) -> Vec<InitialVelocity> {
    let mut velocities = Vec::new();
    for entry in &deck.initial_velocity {
        if entry.value.is_none() && entry.angular.is_none() {
            let diagnostic = Diagnostic::error("`initial_velocity` lacks `value` or `angular`");
            diagnostics.push(diagnostic.at(entry.span, "no velocity here").help("such as value = [0.0, 0.0, -227.0]"));
        }
        let Some(group) = entry.group.group(mesh) else { continue };
        velocities.push(InitialVelocity {
            nodes: group.nodes.clone(),
            translation: entry.value.map_or([0.0; 3], |vector| vector.value),
            spin: entry.angular.as_ref().map(|angular| Spin { rate: angular.rate.value, centre: angular.centre.value }),
        });
    }
    velocities
}

fn loads(deck: &Deck, mesh: &Mesh, diagnostics: &mut Diagnostics) -> Vec<Load> {
    let mut loads: Vec<Load> = Vec::new();
    let mut push = |name: String, kind: LoadKind| {
        let namesakes =
            loads.iter().filter(|load| load.name == name || load.name.starts_with(&format!("{name} ("))).count();
        let name = if namesakes == 0 { name } else { format!("{name} ({})", namesakes + 1) };
        loads.push(Load { name, kind });
    };
    let mut faces = |of: &GroupName<OfFaces>| {
        let group = of.group(mesh)?;
        mesh.outward_faces(group)
            .map_err(|error| diagnostics.push(Diagnostic::error(error.to_string()).at(of.name.span, "this surface")))
            .ok()
    };
    for entry in &deck.pressure {
        let group = &entry.group.name;
        if let (Some(faces), Ok(curve)) =
            (faces(&entry.group), entry.curve.curve(deck.interpolation(entry.interpolation)))
        {
            push(format!("pressure on {}", group.value), LoadKind::Pressure { faces, curve });
        }
    }
    for entry in &deck.traction {
        let group = &entry.group.name;
        if let (Some(faces), Ok(curve)) =
            (faces(&entry.group), entry.curve.curve(deck.interpolation(entry.interpolation)))
        {
            let direction = entry.direction.0;
            push(format!("traction on {}", group.value), LoadKind::Traction { faces, direction, curve });
        }
    }
    for entry in &deck.gravity {
        push("gravity".to_owned(), LoadKind::Gravity { acceleration: entry.acceleration.value });
    }
    loads
}

fn describe_parts(deck: &Deck, mesh: &Mesh) -> Vec<PartDescription> {
    let describe = |part: &deck::model::PartTable| {
        let elements = part.group.group(mesh).map_or(&[][..], |group| &group.elements);
        let volume = |&element: &u32| {
            let element = element as usize;
            volume(mesh.elements().shape(element), &mesh.positions(element))
        };
        let volumes: Vec<f64> = elements.par_iter().map(volume).collect();
        let material = &part.material.0.value;
        let density = deck
            .material
            .0
            .iter()
            .find(|(name, _)| name == material)
            .map_or(0.0, |(_, material)| material.elasticity().density());
        PartDescription {
            group: part.group.name.value.clone(),
            material: material.clone(),
            element_count: elements.len(),
            mass: density * volumes.iter().sum::<f64>(),
        }
    };
    deck.part.iter().map(describe).collect()
}
