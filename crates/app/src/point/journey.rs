//! A material on its way along a path.

use estar_deck::point_column::Row;
use estar_deck::point_path::Path;
use estar_deck::point_problem::Subject;
use estar_material::point::{MaterialPoint, PathError, follow};
use estar_material::{Material, MaterialVisitor};

/// A material's way along the path.
#[derive(Clone, Debug)]
pub struct Journey {
    /// Its rows, the first that of the undeformed state.
    pub rows: Vec<Row>,
    /// What ended it too soon.
    pub trouble: Option<PathError>,
}

impl Journey {
    /// The way of a material along a path.
    pub fn of(subject: &Subject, path: &Path) -> Self {
        subject.model.visit(Along(path))
    }
}

struct Along<'a>(&'a Path);

impl MaterialVisitor for Along<'_> {
    type Output = Journey;

    fn visit<M: Material>(self, material: &M) -> Journey {
        let Self(path) = self;
        let row = |time: f64, point: &MaterialPoint<'_, M>, flows| Row {
            time,
            driven: path.value(time),
            observation: point.observation(),
            flows,
        };
        let mut rows = vec![row(path.times[0], &MaterialPoint::new(material), false)];
        let last = path.times.len() - 1;
        let (mut step, mut strain_old) = (0, 0.0);
        let journey = follow(
            material,
            |time| path.control(time),
            &path.times,
            |time, point| {
                step += 1;
                let strain = point.equivalent_plastic_strain();
                if step % path.every == 0 || step == last {
                    rows.push(row(time, point, strain > strain_old));
                }
                strain_old = strain;
            },
        );
        Journey { rows, trouble: journey.err() }
    }
}
