//! What a material is told of the motion over one step.

use estar_tensor::{Real, Rotation, SymmetricTensor, Tensor};

/// Where the neighbourhood of a point is and how it moves: derivatives by any coordinates ξ that move with the material.
#[derive(Clone, Copy, Debug)]
pub struct PointGradients<R> {
    /// ∂X/∂ξ.
    pub reference: Tensor<R>,
    /// ∂x/∂ξ at t_{n+1}.
    pub position: Tensor<R>,
    /// ∂v/∂ξ, constant over the step.
    pub velocity: Tensor<R>,
}

/// Motion of one point from t_n to t_{n+1}. An element may change it (F-bar) before a material sees it.
#[derive(Clone, Copy, Debug)]
pub struct StepKinematics<R> {
    /// Δt L with L = ∂v/∂x at mid-step.
    pub incremental_displacement_gradient: Tensor<R>,
    /// F_{n+1}.
    pub deformation_gradient: Tensor<R>,
    /// Rotation R_n; none for a [`Motion`] that needs none.
    pub rotation_old: Rotation<R>,
    /// Rotation R_{n+1} of the polar decomposition of F_{n+1}; none for a [`Motion`] that needs none.
    pub rotation_new: Rotation<R>,
}

impl<R: Real> StepKinematics<R> {
    /// No motion.
    pub fn at_rest(deformation_gradient: Tensor<R>, rotation: Rotation<R>) -> Self {
        Self {
            incremental_displacement_gradient: Tensor::zero(),
            deformation_gradient,
            rotation_old: rotation,
            rotation_new: rotation,
        }
    }
}

impl<R: Real> PointGradients<R> {
    /// det(∂X/∂ξ) F_{n+1} = (∂x/∂ξ) cof(∂X/∂ξ)ᵀ, which has the rotation of F, and 1/det(∂X/∂ξ).
    #[inline(always)]
    pub fn scaled_deformation_gradient(&self) -> (Tensor<R>, R) {
        let cofactor = self.reference.cofactor();
        let determinant = self.reference.columns[0].dot(cofactor.columns[0]);
        (self.position.dot(&cofactor.transpose()), determinant.recip())
    }

    /// Δt L = Δt (∂v/∂ξ)(∂x/∂ξ)⁻¹ at the middle of a step of length `time_step` (s), and det(∂x/∂ξ) there.
    #[inline(always)]
    pub fn incremental_displacement_gradient(&self, time_step: f64) -> (Tensor<R>, R) {
        // (∂x/∂ξ)_{n+½} = (∂x/∂ξ)_{n+1} − ½ Δt ∂v/∂ξ
        let half_step = R::splat(-0.5 * time_step);
        let ([a, b, c], [x, y, z]) = (self.velocity.columns, self.position.columns);
        let position_half =
            Tensor { columns: [a.mul_add(half_step, x), b.mul_add(half_step, y), c.mul_add(half_step, z)] };
        let cofactor = position_half.cofactor();
        let volume = position_half.columns[0].dot(cofactor.columns[0]);
        (self.velocity.dot(&cofactor.transpose()) * (volume.recip() * time_step), volume)
    }
}

/// What theories of one kind are told of the motion.
pub trait Motion<R: Real>: Copy {
    /// Whether it depends on the rotations of the polar decomposition; they are not computed where none does.
    const NEEDS_ROTATION: bool;

    /// Whether it depends on F; elements do not compute the F of their choice where none does.
    const NEEDS_DEFORMATION_GRADIENT: bool;

    /// The motion of a step.
    fn new(step: &StepKinematics<R>) -> Self;
}

/// For theories in the frame that turns with the material, as R does.
#[derive(Clone, Copy, Debug)]
pub struct RotatedMotion<R> {
    /// Δt D̃ = Δt R_{n+½}ᵀ D R_{n+½}, the rotation half way from R_n to R_{n+1}.
    pub strain_increment: SymmetricTensor<R>,
}

impl<R: Real> Motion<R> for RotatedMotion<R> {
    const NEEDS_ROTATION: bool = true;
    const NEEDS_DEFORMATION_GRADIENT: bool = false;

    #[inline(always)]
    fn new(step: &StepKinematics<R>) -> Self {
        let rotation_half = step.rotation_old.half_way_to(step.rotation_new);
        Self { strain_increment: step.incremental_displacement_gradient.symmetric_part().pulled_by(&rotation_half) }
    }
}

/// For theories in space.
#[derive(Clone, Copy, Debug)]
pub struct SpatialMotion<R> {
    /// Δt D.
    pub strain_increment: SymmetricTensor<R>,
    /// F_{n+1}.
    pub deformation_gradient: Tensor<R>,
}

impl<R: Real> Motion<R> for SpatialMotion<R> {
    const NEEDS_ROTATION: bool = false;
    const NEEDS_DEFORMATION_GRADIENT: bool = true;

    #[inline(always)]
    fn new(step: &StepKinematics<R>) -> Self {
        Self {
            strain_increment: step.incremental_displacement_gradient.symmetric_part(),
            deformation_gradient: step.deformation_gradient,
        }
    }
}

/// For theories that need all of the motion.
impl<R: Real> Motion<R> for StepKinematics<R> {
    const NEEDS_ROTATION: bool = true;
    const NEEDS_DEFORMATION_GRADIENT: bool = true;

    #[inline(always)]
    fn new(step: &StepKinematics<R>) -> Self {
        *step
    }
}

/// For theories in the reference configuration.
#[derive(Clone, Copy, Debug)]
pub struct ReferenceMotion<R> {
    /// F_{n+1}.
    pub deformation_gradient: Tensor<R>,
    /// J_{n+½}, the mid-step volume over the reference volume.
    pub volume_half: R,
}

impl<R: Real> Motion<R> for ReferenceMotion<R> {
    const NEEDS_ROTATION: bool = false;
    const NEEDS_DEFORMATION_GRADIENT: bool = true;

    #[inline(always)]
    fn new(step: &StepKinematics<R>) -> Self {
        // F_{n+1} = (I + ½ Δt L) F_{n+½}
        let half_step = (step.incremental_displacement_gradient * R::splat(0.5)).plus_spherical(R::splat(1.0));
        Self {
            deformation_gradient: step.deformation_gradient,
            volume_half: step.deformation_gradient.determinant() / half_step.determinant(),
        }
    }
}
