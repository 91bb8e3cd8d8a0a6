//! Values that many keys share: quantities, vectors, curves, names.

use crate::decoder::{At, Decoder, FromDeck, GroupMention, Mention, Named};
use crate::diagnostics::{Diagnostic, Span};
use crate::schema::End::{Excluded, Included};
use crate::schema::{Interval, QuantitySchema, Schema};
use crate::tree::{Node, Value};
use crate::units::{self, Dimension, Measured, UnitError};
use estar_io::{LONGEST_NAME, steers};
use estar_mesh::{Group, Mesh, Wanted};
use estar_solver::{Curve, CurveError, Interpolation};
use std::marker::PhantomData;
use std::path::PathBuf;

/// What a quantity measures and what it may be.
pub trait Measure {
    /// Its dimension.
    const DIMENSION: Dimension;
    /// The values that it may have.
    const INTERVAL: Interval = Interval::ALL;
    /// Whether it is an angle. A plain number that is not 0 could be degrees, and is refused.
    const IS_ANGLE: bool = false;
    /// Whether a curve of it begins with 0: then a first value that is [`NEGLIGIBLE`] is taken as 0, and said so.
    const BEGINS_WITH_ZERO: bool = false;
}

/// A first value so small beside the largest of its curve is the noise of a gauge or of a conversion.
pub const NEGLIGIBLE: f64 = 1e-4;

macro_rules! measures {
    ($( $(#[$doc:meta])* $name:ident = $dimension:ident; )*) => { $(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub struct $name;
        impl Measure for $name {
            const DIMENSION: Dimension = Dimension::$dimension;
        }
    )* };
}

measures! {
    /// A pure number.
    Number = NUMBER;
    /// A length, m.
    Length = LENGTH;
    /// A time, s.
    Time = TIME;
    /// A density, kg/m³.
    Density = DENSITY;
    /// A stress, Pa.
    Stress = STRESS;
    /// A velocity, m/s.
    Velocity = VELOCITY;
    /// An acceleration, m/s².
    Acceleration = ACCELERATION;
    /// A rate of rotation or of strain, 1/s.
    Rate = RATE;
    /// A temperature, K.
    Temperature = TEMPERATURE;
    /// A specific heat, J/(kg K).
    SpecificHeat = SPECIFIC_HEAT;
}

/// `M`, greater than 0.
#[derive(Clone, Copy, Debug)]
pub struct Positive<M>(PhantomData<M>);

impl<M: Measure> Measure for Positive<M> {
    const DIMENSION: Dimension = M::DIMENSION;
    const IS_ANGLE: bool = M::IS_ANGLE;
    const INTERVAL: Interval = Interval::POSITIVE;
}

/// `M`, 0 or greater.
#[derive(Clone, Copy, Debug)]
pub struct NotNegative<M>(PhantomData<M>);

impl<M: Measure> Measure for NotNegative<M> {
    const DIMENSION: Dimension = M::DIMENSION;
    const IS_ANGLE: bool = M::IS_ANGLE;
    const INTERVAL: Interval = Interval { low: Some(Included(0.0)), high: None };
}

/// An angle, rad, written with its unit.
#[derive(Clone, Copy, Debug)]
pub struct Angle;

impl Measure for Angle {
    const DIMENSION: Dimension = Dimension::NUMBER;
    const IS_ANGLE: bool = true;
}

/// A displacement from the first position, m.
#[derive(Clone, Copy, Debug)]
pub struct Displacement;

impl Measure for Displacement {
    const DIMENSION: Dimension = Dimension::LENGTH;
    const BEGINS_WITH_ZERO: bool = true;
}

/// A number that Poisson's ratio of a stable solid can be.
#[derive(Clone, Copy, Debug)]
pub struct PoissonRatio;

impl Measure for PoissonRatio {
    const DIMENSION: Dimension = Dimension::NUMBER;
    const INTERVAL: Interval = Interval { low: Some(Excluded(-1.0)), high: Some(Excluded(0.5)) };
}

/// A fraction of one: greater than 0, at most 1.
#[derive(Clone, Copy, Debug)]
pub struct Fraction;

impl Measure for Fraction {
    const DIMENSION: Dimension = Dimension::NUMBER;
    const INTERVAL: Interval = Interval { high: Some(Included(1.0)), ..Interval::POSITIVE };
}

/// A factor that makes greater: 1 or more.
#[derive(Clone, Copy, Debug)]
pub struct AtLeastOne;

impl Measure for AtLeastOne {
    const DIMENSION: Dimension = Dimension::NUMBER;
    const INTERVAL: Interval = Interval { low: Some(Included(1.0)), high: None };
}

/// A number so great that what lasts so many half periods of a vibration can be called slow.
#[derive(Clone, Copy, Debug)]
pub struct AtLeastTen;

impl Measure for AtLeastTen {
    const DIMENSION: Dimension = Dimension::NUMBER;
    const INTERVAL: Interval = Interval { low: Some(Included(10.0)), high: None };
}

/// A share of a whole: from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub struct Share;

impl Measure for Share {
    const DIMENSION: Dimension = Dimension::NUMBER;
    const INTERVAL: Interval = Interval { low: Some(Included(0.0)), high: Some(Included(1.0)) };
}

/// A quantity in SI units.
#[derive(Clone, Copy, Debug)]
pub struct Quantity<M> {
    /// The value in SI units.
    pub value: f64,
    measure: PhantomData<M>,
}

impl<M: Measure> Quantity<M> {
    /// The quantity of this value in SI units.
    pub fn new(value: f64) -> Self {
        Self { value, measure: PhantomData }
    }
}

fn quantity_schema<M: Measure>() -> QuantitySchema {
    QuantitySchema { dimension: Some(M::DIMENSION), interval: M::INTERVAL, is_angle: M::IS_ANGLE }
}

impl<M: Measure> FromDeck for Quantity<M> {
    fn schema() -> Schema {
        Schema::Quantity(quantity_schema::<M>())
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let measured = decode_measured(node, decoder, Some(M::DIMENSION))?;
        if let Some(dimension) = measured.dimension
            && dimension != M::DIMENSION
        {
            wrong_dimension(node.span, dimension, M::DIMENSION, decoder);
            return None;
        }
        if M::IS_ANGLE && measured.dimension.is_none() && measured.value != 0.0 {
            let diagnostic = Diagnostic::error(format!("`{}` is an angle without a unit", decoder.place()));
            let help = format!("\"{0} deg\" or \"{0} rad\"", measured.value);
            decoder.report(diagnostic.at(node.span, "degrees or radians?").help(help));
            return None;
        }
        if !M::INTERVAL.contains(measured.value) {
            let bound = M::INTERVAL.words().filter(|_| measured.value.is_finite());
            let bound = bound.unwrap_or_else(|| "a finite number".to_owned());
            let diagnostic = Diagnostic::error(format!("`{}` must be {bound}", decoder.place()));
            let unit = match M::DIMENSION.si_unit() {
                one if one == "1" => String::new(),
                unit => format!(" {unit}"),
            };
            decoder.report(diagnostic.at(node.span, format!("this is {:?}{unit}", measured.value)));
            return None;
        }
        Some(Self::new(measured.value))
    }
}

/// Reports a unit of the wrong dimension.
pub fn wrong_dimension(span: Span, given: Dimension, wanted: Dimension, decoder: &mut Decoder) {
    let message = format!("`{}` must be {wanted}, not {given}", decoder.place());
    let label = format!("its unit is that of {given}");
    let help = format!("{wanted} is {}", as_written(wanted));
    decoder.report(Diagnostic::error(message).at(span, label).help(help));
}

/// How a quantity of a dimension is written.
fn as_written(dimension: Dimension) -> String {
    match dimension {
        Dimension::NUMBER => "a number such as 0.3 or a string such as \"30 %\"".to_owned(),
        _ => format!("a number in {} or a string such as \"{}\"", dimension.si_unit(), dimension.example()),
    }
}

/// A number, or a string with a unit of any dimension.
fn decode_measured(node: &Node, decoder: &mut Decoder, wanted: Option<Dimension>) -> Option<Measured> {
    let wanted_text = || match wanted {
        Some(dimension) => as_written(dimension),
        None => "a number or a string with a unit".to_owned(),
    };
    let text = match &node.value {
        Value::Integer(text) | Value::Float(text) => {
            let value = text.parse().unwrap_or(f64::NAN);
            return Some(Measured { value, dimension: None, is_percentage: false, zero: 0.0 });
        }
        Value::Text(text) => text,
        _ => {
            decoder.wrong_type(node, &wanted_text());
            return None;
        }
    };
    match units::parse(text) {
        Ok(measured) => Some(measured),
        Err(error) => {
            let label = match &error {
                UnitError::Unknown { similar: Some(similar), .. } => format!("did you mean `{similar}`?"),
                other => other.to_string(),
            };
            let diagnostic = Diagnostic::error(format!("`{}` cannot be read: {error}", decoder.place()));
            decoder.report(diagnostic.at(node.span, label).help(wanted_text()));
            None
        }
    }
}

/// A quantity whose dimension follows from another part of the deck.
#[derive(Clone, Copy, Debug)]
pub struct AnyQuantity(pub Measured);

impl FromDeck for AnyQuantity {
    fn schema() -> Schema {
        Schema::Quantity(QuantitySchema { dimension: None, interval: Interval::ALL, is_angle: false })
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let measured = decode_measured(node, decoder, None)?;
        if !measured.value.is_finite() {
            let diagnostic = Diagnostic::error(format!("`{}` must be a finite number", decoder.place()));
            decoder.report(diagnostic.at(node.span, format!("this is {:?}", measured.value)));
            return None;
        }
        Some(Self(measured))
    }
}

/// Three quantities of one measure.
#[derive(Clone, Copy, Debug)]
pub struct Vector<M> {
    /// The components in SI units.
    pub value: [f64; 3],
    measure: PhantomData<M>,
}

impl<M: Measure> FromDeck for Vector<M> {
    fn schema() -> Schema {
        Schema::Vector(quantity_schema::<M>(), 3)
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let wanted = "a list of three numbers [x, y, z]";
        let Value::List(list) = &node.value else {
            decoder.wrong_type(node, wanted);
            return None;
        };
        let mut component = |node| Quantity::<M>::decode(node, decoder).map(|quantity| quantity.value);
        let components: Vec<Option<f64>> = list.iter().map(&mut component).collect();
        let [x, y, z] = components[..] else {
            let message = format!("`{}` must have three components, not {}", decoder.place(), list.len());
            decoder.report(Diagnostic::error(message).at(node.span, wanted));
            return None;
        };
        Some(Self { value: [x?, y?, z?], measure: PhantomData })
    }
}

/// A direction: a vector other than zero, brought to length 1.
#[derive(Clone, Copy, Debug)]
pub struct UnitVector(pub [f64; 3]);

impl FromDeck for UnitVector {
    fn schema() -> Schema {
        Schema::Direction
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let vector = Vector::<Number>::decode(node, decoder)?.value;
        // scaled first, so that no square can overflow
        let largest = vector.iter().fold(0.0_f64, |largest, c| largest.max(c.abs()));
        let scaled = vector.map(|c| c / largest);
        let length = scaled.iter().map(|c| c * c).sum::<f64>().sqrt();
        if largest == 0.0 || !length.is_finite() {
            let message = format!("`{}` must have a direction", decoder.place());
            decoder.report(Diagnostic::error(message).at(node.span, "a vector other than zero is needed"));
            return None;
        }
        Some(Self(scaled.map(|c| c / length)))
    }
}

/// Points of a function of time.
#[derive(Clone, Debug)]
pub struct TimePoints<M> {
    points: Vec<[f64; 2]>,
    measure: PhantomData<M>,
}

impl<M: Measure> TimePoints<M> {
    /// The curve through the points, which were checked when they were read.
    pub fn curve(&self, interpolation: Interpolation) -> Result<Curve, CurveError> {
        Curve::new(self.points.clone(), interpolation)
    }

    /// The same points, the first with another value.
    pub fn beginning_with(&self, value: f64) -> Self {
        let mut points = self.points.clone();
        points.iter_mut().take(1).for_each(|point| point[1] = value);
        Self { points, measure: PhantomData }
    }
}

/// A warning that a curve is taken to begin with `taken`, not with `given`.
pub fn begins_with(place: &str, given: &str, taken: &str) -> Diagnostic {
    let message = format!("`{place}` begins with {given}, which is taken as {taken}");
    Diagnostic::warning(message).help(format!("it is at most {NEGLIGIBLE:?} of the most that the curve reaches"))
}

impl<M: Measure> FromDeck for TimePoints<M> {
    fn schema() -> Schema {
        Schema::Points(quantity_schema::<Time>(), quantity_schema::<M>())
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let points = decode_pairs::<Time, M>(node, decoder, "[time, value]")?;
        if let Err(error) = Curve::new(points.clone(), Interpolation::Linear) {
            let culprit = match error {
                CurveError::NotIncreasing { index, .. } | CurveError::NotFinite { index } => Some(index),
                CurveError::Empty => None,
            };
            let span = match (&node.value, culprit) {
                (Value::List(list), Some(index)) => list.get(index).map_or(node.span, |point| point.span),
                _ => node.span,
            };
            decoder.report(Diagnostic::error(format!("`{}`: {error}", decoder.place())).at(span, "here"));
            return None;
        }
        let read = Self { points, measure: PhantomData };
        let largest = read.points.iter().fold(0.0_f64, |largest, point| largest.max(point[1].abs()));
        let first = read.points[0][1];
        if M::BEGINS_WITH_ZERO && first != 0.0 && first.abs() <= NEGLIGIBLE * largest {
            let span = if let Value::List(list) = &node.value { list[0].span } else { node.span };
            let warning = begins_with(&decoder.place(), &format!("{first:?} m"), "0");
            decoder.report(warning.at(span, "the first point"));
            return Some(read.beginning_with(0.0));
        }
        Some(read)
    }
}

/// A list of pairs of quantities.
pub fn decode_pairs<X: Measure, Y: Measure>(node: &Node, decoder: &mut Decoder, pair: &str) -> Option<Vec<[f64; 2]>> {
    let Value::List(list) = &node.value else {
        let help = match &node.value {
            Value::Text(_) => {
                Some(format!("points stand in the deck, no file is read: {} = [[0.0, 0.0], ...]", decoder.key()))
            }
            _ => None,
        };
        decoder.wrong_form(node, &format!("a list of points {pair}"), help);
        return None;
    };
    let mut points = Vec::with_capacity(list.len());
    let mut is_good = true;
    for point in list {
        match &point.value {
            Value::List(pair) if pair.len() == 2 => {
                let x = Quantity::<X>::decode(&pair[0], decoder);
                let y = Quantity::<Y>::decode(&pair[1], decoder);
                match (x, y) {
                    (Some(x), Some(y)) => points.push([x.value, y.value]),
                    _ => is_good = false,
                }
            }
            _ => {
                let message = format!("a point of `{}` must be {pair}", decoder.place());
                decoder.report(Diagnostic::error(message).at(point.span, format!("{pair} is needed")));
                is_good = false;
            }
        }
    }
    is_good.then_some(points)
}

impl FromDeck for String {
    fn schema() -> Schema {
        Schema::Text("a string")
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        match &node.value {
            Value::Text(text) => Some(text.clone()),
            _ => {
                decoder.wrong_type(node, "a string");
                None
            }
        }
    }
}

/// A whole number from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Count(pub u64);

impl FromDeck for Count {
    fn schema() -> Schema {
        Schema::Count
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let count = match &node.value {
            Value::Integer(text) => text.parse().ok().filter(|count| *count > 0),
            _ => None,
        };
        if count.is_none() {
            let message = format!("`{}` must be a whole number from 1", decoder.place());
            decoder.report(Diagnostic::error(message).at(node.span, "a whole number from 1 is needed"));
        }
        count.map(Self)
    }
}

impl<T: FromDeck> FromDeck for Vec<T> {
    fn schema() -> Schema {
        Schema::List(Box::new(T::schema()))
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let Value::List(list) = &node.value else {
            let wanted = match T::schema() {
                Schema::Table(_) => format!("a list of tables, each headed [[{}]]", decoder.place()),
                _ => "a list".to_owned(),
            };
            let help = match &node.value {
                Value::Text(text) => Some(format!("{} = [\"{text}\"]", decoder.key())),
                _ => None,
            };
            decoder.wrong_form(node, &wanted, help);
            return None;
        };
        let values: Vec<Option<T>> = list.iter().map(|node| T::decode(node, decoder)).collect();
        values.into_iter().collect()
    }
}

/// What a name must be to stand in messages, in ledgers and at the head of a column.
pub fn checked_name(name: &str, span: Span, what: Named, decoder: &mut Decoder) -> Option<()> {
    checked_length(name, span, &what.to_string(), decoder)?;
    if !name.trim().is_empty() && !name.chars().any(|c| steers(c) || matches!(c, ',' | '"' | ';')) {
        return Some(());
    }
    let message = format!("a {what} cannot be named {name:?}");
    let help = "a name has at least one character to be seen, and none of these: comma, semicolon, quote, control \
                character such as a line break, mark of the direction of writing";
    decoder.report(Diagnostic::error(message).at(span, "this name").help(help));
    None
}

/// Reports a name that is longer than any that is read from a mesh, or shown.
fn checked_length(name: &str, span: Span, what: &str, decoder: &mut Decoder) -> Option<()> {
    let length = name.chars().count();
    if length <= LONGEST_NAME {
        return Some(());
    }
    let message = format!("the name of a {what} has {length} characters, where up to {LONGEST_NAME} are read");
    decoder.report(Diagnostic::error(message).at(span, "this name").help("take a shorter one"));
    None
}

/// Tables under names that the user gives.
#[derive(Clone, Debug)]
pub struct Materials<T>(pub Vec<(String, T)>);

impl<T: FromDeck> FromDeck for Materials<T> {
    fn schema() -> Schema {
        Schema::Named(Box::new(T::schema()))
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let Value::Table(table) = &node.value else {
            decoder.wrong_type(node, "a table with a name, such as [material.copper]");
            return None;
        };
        let mut values = Vec::new();
        let mut is_good = true;
        for entry in &table.entries {
            let name = At { value: entry.key.clone(), span: entry.key_span };
            is_good &= checked_name(&entry.key, entry.key_span, Named::Material, decoder).is_some();
            decoder.definitions.push(Mention { of: Named::Material, name });
            match decoder.value(&entry.key, &entry.node) {
                Some(value) => values.push((entry.key.clone(), value)),
                None => is_good = false,
            }
        }
        is_good.then_some(Self(values))
    }
}

/// The name of a material of the deck.
#[derive(Clone, Debug)]
pub struct MaterialName(pub At<String>);

impl FromDeck for MaterialName {
    fn schema() -> Schema {
        Schema::Text("the name of a material: NAME of [material.NAME]")
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let name = At::<String>::decode(node, decoder)?;
        checked_length(&name.value, name.span, "material", decoder)?;
        decoder.mentions.push(Mention { of: Named::Material, name: name.clone() });
        Some(Self(name))
    }
}

/// The name of a probe, where it is defined.
#[derive(Clone, Debug)]
pub struct NewProbeName(pub At<String>);

impl FromDeck for NewProbeName {
    fn schema() -> Schema {
        Schema::Text("a name of your own, which heads the probe's column in history.csv")
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let name = At::<String>::decode(node, decoder)?;
        decoder.definitions.push(Mention { of: Named::Probe, name: name.clone() });
        checked_name(&name.value, name.span, Named::Probe, decoder)?;
        Some(Self(name))
    }
}

/// The name of a rigid wall, where it is defined.
#[derive(Clone, Debug)]
pub struct NewWallName(pub At<String>);

impl FromDeck for NewWallName {
    fn schema() -> Schema {
        Schema::Text("a name of your own")
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let name = At::<String>::decode(node, decoder)?;
        decoder.definitions.push(Mention { of: Named::Wall, name: name.clone() });
        checked_name(&name.value, name.span, Named::Wall, decoder)?;
        Some(Self(name))
    }
}

/// The name of a rigid wall, where it is used.
#[derive(Clone, Debug)]
pub struct WallName(pub At<String>);

impl FromDeck for WallName {
    fn schema() -> Schema {
        Schema::Text("the name of a rigid wall")
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let name = At::<String>::decode(node, decoder)?;
        checked_length(&name.value, name.span, "rigid wall", decoder)?;
        decoder.mentions.push(Mention { of: Named::Wall, name: name.clone() });
        Some(Self(name))
    }
}

/// The name of a probe, where it is used.
#[derive(Clone, Debug)]
pub struct ProbeName(pub At<String>);

impl FromDeck for ProbeName {
    fn schema() -> Schema {
        Schema::Text("the name of a probe")
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let name = At::<String>::decode(node, decoder)?;
        checked_length(&name.value, name.span, "probe", decoder)?;
        decoder.mentions.push(Mention { of: Named::Probe, name: name.clone() });
        Some(Self(name))
    }
}

/// The file of the mesh.
#[derive(Clone, Debug)]
pub struct MeshFile(pub At<PathBuf>);

impl FromDeck for MeshFile {
    fn schema() -> Schema {
        Schema::Text("a path, relative to the deck")
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let name = String::decode(node, decoder)?;
        if name.is_empty() {
            decoder.report(Diagnostic::error("the path of the mesh is empty").at(node.span, "a file is needed"));
            return None;
        }
        let file = At { value: decoder.file(&name), span: node.span };
        decoder.mesh_file = Some(file.clone());
        Some(Self(file))
    }
}

/// What of a group a key takes.
pub trait OfGroup {
    /// What is wanted.
    const WANTED: Wanted;
}

/// The elements of a group.
#[derive(Clone, Copy, Debug)]
pub struct OfElements;

impl OfGroup for OfElements {
    const WANTED: Wanted = Wanted::Elements;
}

/// The faces of a group.
#[derive(Clone, Copy, Debug)]
pub struct OfFaces;

impl OfGroup for OfFaces {
    const WANTED: Wanted = Wanted::Faces;
}

/// The nodes of a group of any kind.
#[derive(Clone, Copy, Debug)]
pub struct OfNodes;

impl OfGroup for OfNodes {
    const WANTED: Wanted = Wanted::Nodes;
}

/// The name of a group of the mesh.
#[derive(Clone, Debug)]
pub struct GroupName<K> {
    /// The name.
    pub name: At<String>,
    wanted: PhantomData<K>,
}

impl<K: OfGroup> GroupName<K> {
    /// The group that is meant, which the mesh has once the mentions are checked.
    pub fn group<'mesh>(&self, mesh: &'mesh Mesh) -> Option<&'mesh Group> {
        mesh.find(&self.name.value, K::WANTED).ok()
    }

    /// Its nodes.
    pub fn nodes(&self, mesh: &Mesh) -> Option<Vec<u32>> {
        self.group(mesh).map(|group| group.nodes.clone())
    }
}

impl<K: OfGroup> FromDeck for GroupName<K> {
    fn schema() -> Schema {
        Schema::Group(K::WANTED.kinds())
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let name = At::<String>::decode(node, decoder)?;
        checked_length(&name.value, name.span, "group", decoder)?;
        decoder.groups.push(GroupMention { name: name.clone(), wanted: K::WANTED });
        Some(Self { name, wanted: PhantomData })
    }
}
