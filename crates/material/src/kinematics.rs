//! What a material is told of the motion over one step.

use estar_tensor::{Real, Rotation, Tensor, array};

/// Motion of one quadrature point from t_n to t_{n+1}, with what the element does to it (F-bar) already applied.
#[derive(Clone, Copy, Debug)]
pub struct StepKinematics<R> {
    /// Velocity gradient L = ∂v/∂x at mid-step, 1/s.
    pub velocity_gradient: Tensor<R>,
    /// Deformation gradient F_{n+1}.
    pub deformation_gradient: Tensor<R>,
    /// Rotation R_{n+½}, half way from R_n to R_{n+1}.
    pub rotation_half: Tensor<R>,
    /// Rotation R_{n+1} of the polar decomposition of F_{n+1}.
    pub rotation_new: Tensor<R>,
}

/// The motion of a step together with what the element needs of it.
#[derive(Clone, Copy, Debug)]
pub struct PointMotion<R> {
    /// What the material sees.
    pub kinematics: StepKinematics<R>,
    /// R_{n+1} as a quaternion, the guess of the next step.
    pub rotation: Rotation<R>,
    /// det F_{n+½}.
    pub jacobian_half: R,
    /// det F_{n+1}.
    pub jacobian_new: R,
}

impl<R: Real> PointMotion<R> {
    /// The motion that ends at `deformation_gradient` = F_{n+1} after the constant rate `rate` = Ḟ over `time_step`.
    ///
    /// `rotation_old` is R_n, the first guess of the polar decomposition of F_{n+1}. Where `needs_rotation` is false that
    /// is left out: the rotations of the result are the identity.
    #[inline(always)]
    pub fn new(
        deformation_gradient: Tensor<R>,
        rate: &Tensor<R>,
        time_step: f64,
        rotation_old: Rotation<R>,
        needs_rotation: bool,
    ) -> Self {
        // F_{n+½} = F_{n+1} − ½ Δt Ḟ
        let half_step = R::splat(-0.5 * time_step);
        let gradient_half =
            Tensor { columns: array(|j| rate.columns[j].mul_add(half_step, deformation_gradient.columns[j])) };
        let cofactor_half = gradient_half.cofactor();
        let jacobian_half = gradient_half.columns[0].dot(cofactor_half.columns[0]);
        // L = Ḟ F_{n+½}⁻¹
        let velocity_gradient = rate.dot(&(cofactor_half.transpose() * jacobian_half.recip()));
        let (rotation, rotation_half, rotation_new) = if needs_rotation {
            let rotation = Rotation::nearest(&deformation_gradient, rotation_old);
            (rotation, rotation_old.half_way_to(rotation).to_tensor(), rotation.to_tensor())
        } else {
            (rotation_old, Tensor::identity(), Tensor::identity())
        };
        let kinematics = StepKinematics { velocity_gradient, deformation_gradient, rotation_half, rotation_new };
        Self { kinematics, rotation, jacobian_half, jacobian_new: deformation_gradient.determinant() }
    }
}
