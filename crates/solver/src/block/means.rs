//! Means over the points of elements, as a user sees them.

use super::element_block::ElementMeans;
use crate::patch::MOST_LANES;
use estar_element::element::{ElementHistory, OwnHistory};
use estar_material::points::MaterialPoints;
use estar_tensor::{Real, array};

/// Writes the means over the points of each element of a patch to their places in the fields; the place of the first is at their
/// beginning.
pub(super) fn write_means<R: Real, Own: OwnHistory<R>>(
    points: &dyn MaterialPoints<R>,
    members: &[u32],
    history: &[ElementHistory<R, Own>],
    means: ElementMeans<'_>,
) {
    let ElementMeans { mut cauchy_stress, mut equivalent_plastic_strain, mut temperature, mut volume_ratio } = means;
    let mut lanes = [[0.0; MOST_LANES]; 6];
    for (pack, (history, of_pack)) in history.iter().zip(members.chunks(R::LANES)).enumerate() {
        let places = || of_pack.iter().map(|element| (element - members[0]) as usize).enumerate();
        if let Some(field) = &mut cauchy_stress {
            let mut mean = points.mean_stress(pack);
            if let Some(shared) = history.own.neighbourhood() {
                // dev T + σ̄ I, of which the forces are
                mean = mean.plus_spherical(shared.mean_stress - mean.trace() * (1.0 / 3.0));
            }
            for (lanes, component) in lanes.iter_mut().zip(mean.0) {
                component.store(lanes);
            }
            for (lane, place) in places() {
                field[place] = array(|component| lanes[component][lane]);
            }
        }
        let [lanes, ..] = &mut lanes;
        if let Some(field) = &mut equivalent_plastic_strain {
            points.mean_plastic_strain(pack).store(lanes);
            places().for_each(|(lane, place)| field[place] = lanes[lane]);
        }
        if let Some(field) = &mut temperature {
            points.mean_temperature(pack).store(lanes);
            places().for_each(|(lane, place)| field[place] = lanes[lane]);
        }
        if let (Some(field), Some(shared)) = (&mut volume_ratio, history.own.neighbourhood()) {
            shared.jacobian.store(lanes);
            places().for_each(|(lane, place)| field[place] = lanes[lane]);
        }
    }
}
