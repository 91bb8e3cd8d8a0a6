//! point.png and point.svg.

use super::journey::Journey;
use estar_deck::point_column::{Column, Dimension, Driven, Quantity};
use estar_deck::point_problem::PointProblem;
use estar_post::plot::{Axis, Curve, Panel};

/// The panels that the deck asks for, or those that suit the path.
pub fn panels(problem: &PointProblem, journeys: &[Journey]) -> impl ExactSizeIterator<Item = Panel> {
    let driven = problem.path.driven();
    let panels: Vec<(Column, Vec<Column>)> = if problem.plots.is_empty() {
        let shows = |(_, y): &(Column, Vec<Column>)| y.iter().any(|column| is_worth_showing(*column, journeys));
        default_panels(driven).into_iter().filter(shows).collect()
    } else {
        problem.plots.clone()
    };
    panels.into_iter().map(|(x, y)| panel(x, &y, problem, journeys))
}

fn default_panels(driven: Driven) -> Vec<(Column, Vec<Column>)> {
    let stress = Column::stress;
    let component = Column::Component;
    let panels = match driven {
        Driven::Stretch(_) => vec![
            vec![stress(0), component(Quantity::SecondPiolaStress, 0)],
            vec![component(Quantity::PlasticStrain, 0)],
            vec![component(Quantity::ElasticStrain, 0)],
            vec![Column::EquivalentPlasticStrain],
        ],
        Driven::Shear => vec![
            vec![stress(3)],
            vec![stress(0), stress(1)],
            vec![component(Quantity::PlasticStrain, 3)],
            vec![Column::EquivalentPlasticStrain],
        ],
        Driven::Time => vec![
            vec![stress(0), stress(1), stress(2)],
            vec![stress(3), stress(4), stress(5)],
            vec![Column::EquivalentPlasticStrain],
            vec![Column::PlasticDeterminant],
        ],
    };
    panels.into_iter().map(|columns| (Column::Driven, columns)).collect()
}

/// Whether a column has anything but its first value.
fn is_worth_showing(column: Column, journeys: &[Journey]) -> bool {
    journeys.iter().any(|journey| {
        let mut values = journey.rows.iter().filter_map(|row| column.value(row));
        let first = values.next();
        values.any(|value| Some(value) != first)
    })
}

fn panel(x: Column, y: &[Column], problem: &PointProblem, journeys: &[Journey]) -> Panel {
    let driven = problem.path.driven();
    let values = |columns: &[Column]| -> Vec<f64> {
        let rows = journeys.iter().flat_map(|journey| &journey.rows);
        rows.flat_map(|row| columns.iter().filter_map(|column| column.value(row))).collect()
    };
    let (x_unit, y_unit) =
        (Unit::for_values(x.dimension(), &values(&[x])), Unit::for_values(y[0].dimension(), &values(y)));
    let label = match y {
        [column] => column.title(driven),
        columns => columns.iter().map(|column| column.symbol(driven)).collect::<Vec<_>>().join(", "),
    };
    let mut curves = Vec::new();
    for (material, (subject, journey)) in problem.subjects.iter().zip(journeys).enumerate() {
        for (quantity, column) in y.iter().enumerate() {
            let point = |row| Some([x.value(row)? / x_unit.size, column.value(row)? / y_unit.size]);
            let label = match (problem.subjects.len(), y.len()) {
                (_, 1) => subject.label.clone(),
                (1, _) => column.symbol(driven),
                _ => format!("{}, {}", column.symbol(driven), subject.label),
            };
            // a material has its colour and a quantity its dashes, where there are several of both
            let (colour, dash) = match (problem.subjects.len(), y.len()) {
                (_, 1) => (material, material),
                (1, _) => (quantity, quantity),
                _ => (material, quantity),
            };
            let is_broad = material == 0 && problem.subjects.len() > 1 && y.len() > 1;
            curves.push(Curve {
                label,
                colour,
                dash,
                is_broad,
                is_dotted: false,
                points: journey.rows.iter().filter_map(point).collect(),
            });
        }
    }
    Panel {
        x: Axis { label: x.title(driven), unit: x_unit.name, is_logarithmic: false },
        y: Axis { label, unit: y_unit.name, is_logarithmic: false },
        is_isometric: false,
        curves,
    }
}

/// A unit in which the numbers of an axis are easy to read.
struct Unit {
    name: String,
    /// In SI units.
    size: f64,
}

impl Unit {
    fn for_values(dimension: Dimension, values: &[f64]) -> Self {
        let base = match dimension {
            Dimension::Number => return Self { name: String::new(), size: 1.0 },
            Dimension::Temperature => return Self { name: "K".to_owned(), size: 1.0 },
            Dimension::Time => return Self { name: "s".to_owned(), size: 1.0 },
            Dimension::LoadingRate => return Self { name: "Pa²/s".to_owned(), size: 1.0 },
            Dimension::Stress => "Pa",
            Dimension::EnergyDensity => "J/m³",
        };
        let largest =
            values.iter().filter(|value| value.is_finite()).fold(0.0_f64, |most, value| most.max(value.abs()));
        let prefixes = [(1e9, "G"), (1e6, "M"), (1e3, "k")];
        // 999 MPa is easier to read than 0.999 GPa, and 1.2 GPa than 1200 MPa
        let (size, prefix) = prefixes.into_iter().find(|(size, _)| largest >= *size).unwrap_or((1.0, ""));
        Self { name: format!("{prefix}{base}"), size }
    }
}
