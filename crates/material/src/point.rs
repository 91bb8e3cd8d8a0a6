//! The material-point driver: a material along a path of deformation gradients, without a mesh.

use crate::{Material, MaterialUpdate, Motion, PointGradients, StepKinematics};
use estar_tensor::{Real, Rotation, SymmetricTensor, Tensor};

/// One material point with its history.
#[derive(Clone, Debug)]
pub struct MaterialPoint<'a, M: Material, R: Real = f64> {
    material: &'a M,
    state: M::State<R>,
    rotation: Rotation<R>,
    deformation_gradient: Tensor<R>,
    stress: SymmetricTensor<R>,
    internal_energy: R,
    plastic_dissipation: R,
}

impl<'a, M: Material, R: Real> MaterialPoint<'a, M, R> {
    /// The undeformed point.
    pub fn new(material: &'a M) -> Self {
        Self {
            material,
            state: material.initial_state(),
            rotation: Rotation::identity(),
            deformation_gradient: Tensor::identity(),
            stress: SymmetricTensor::zero(),
            internal_energy: R::splat(0.0),
            plastic_dissipation: R::splat(0.0),
        }
    }

    /// Moves the point in a straight line to the deformation gradient `target` in the time `time_step` (s).
    #[inline(always)]
    pub fn advance(&mut self, target: &Tensor<R>, time_step: f64) {
        let rate = (*target - self.deformation_gradient) * R::splat(time_step.recip());
        // ξ = X
        let gradients = PointGradients { reference: Tensor::identity(), position: *target, velocity: rate };
        let rotation = Rotation::nearest(target, self.rotation);
        let (displacement_gradient, volume_half) = gradients.displacement_gradient(time_step);
        let motion = M::Motion::new(&StepKinematics {
            displacement_gradient,
            deformation_gradient: *target,
            rotation_old: self.rotation,
            rotation_new: rotation,
        });
        let update = self.material.update(&self.state, &motion);
        let MaterialUpdate { state, internal_energy, plastic_dissipation } = update;
        // per reference volume: dV = J_{n+½} dV₀
        self.internal_energy += internal_energy * volume_half;
        self.plastic_dissipation += plastic_dissipation * volume_half;
        self.stress = self.material.cauchy_stress(&state, rotation);
        self.state = state;
        self.rotation = rotation;
        self.deformation_gradient = *target;
    }

    /// Cauchy stress T, Pa.
    pub fn stress(&self) -> &SymmetricTensor<R> {
        &self.stress
    }

    /// Rotated Cauchy stress RᵀTR, Pa.
    pub fn rotated_stress(&self) -> SymmetricTensor<R> {
        self.stress.pulled_by(&self.rotation.to_tensor())
    }

    /// ε̄ᵖ.
    pub fn equivalent_plastic_strain(&self) -> R {
        self.material.equivalent_plastic_strain(&self.state)
    }

    /// History.
    pub fn state(&self) -> &M::State<R> {
        &self.state
    }

    /// F.
    pub fn deformation_gradient(&self) -> &Tensor<R> {
        &self.deformation_gradient
    }

    /// Stress power integrated over time, J per m³ of reference volume.
    pub fn internal_energy(&self) -> R {
        self.internal_energy
    }

    /// Its dissipated part, J/m³ of reference volume.
    pub fn plastic_dissipation(&self) -> R {
        self.plastic_dissipation
    }
}

/// The point after the path `deformation_gradient(time)`, 0 < time ≤ `end`, in `steps` equal steps; `visit` sees it
/// after each.
pub fn drive<'a, M: Material>(
    material: &'a M,
    deformation_gradient: impl Fn(f64) -> Tensor<f64>,
    end: f64,
    steps: u32,
    mut visit: impl FnMut(f64, &MaterialPoint<'a, M>),
) -> MaterialPoint<'a, M> {
    let mut point = MaterialPoint::new(material);
    for step in 1..=steps {
        let time = end * f64::from(step) / f64::from(steps);
        point.advance(&deformation_gradient(time), end / f64::from(steps));
        visit(time, &point);
    }
    point
}
