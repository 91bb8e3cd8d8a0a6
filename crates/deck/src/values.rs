//! Values that many keys share: quantities, vectors, curves, texts, counts, lists.

use crate::decoder::{Decoder, FromDeck};
use crate::diagnostics::{Diagnostic, Span};
use crate::schema::End::{Excluded, Included};
use crate::schema::{Interval, QuantitySchema, Schema};
use crate::tree::{Node, Value};
use crate::units::{self, Dimension, Measured, UnitError};
use estar_solver::{Curve, CurveError, Interpolation};
use std::marker::PhantomData;

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
fn wrong_dimension(span: Span, given: Dimension, wanted: Dimension, decoder: &mut Decoder) {
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
