//! The Green-Naghdi Lagrangian theory, linear in E − E_p, for comparison with the E* theory (Green & Naghdi 1965; de Vera
//! 2016, sections 7.1 and 7.5.2).
//!
//! Green's strain E = ½ (FᵀF − I), plastic strain E_p a variable of its own, second Piola-Kirchhoff stress S:
//!
//! - elasticity   S = 2μ dev(E − E_p) + k tr(E − E_p) I (dV 7.6, 7.9)
//! - yield        √(3/2) ‖dev S‖ ≤ σ_y(ε̄ᵖ), which is ½ dev S : dev S ≤ K² with √3 K = σ_y (dV 7.12)
//! - flow         Ė_p = ψ dev S, ψ = dev S : dev Ė/(2K²) in perfect plasticity (dV 7.17), ε̄̇ᵖ = √⅔ ‖Ė_p‖
//!
//! E − E_p is no elastic strain where plastic strain is large: in uniaxial tension S stays at the yield stress while the
//! Cauchy stress grows with λ₁/λ₂². tr E_p = 0 is not det U_p = 1 either, and in compression I + 2 E_p need not even be
//! positive definite. In space the elasticity is that of L pushed forward, stiffer by up to λ_max(FFᵀ)²/J.
//!
//! Nor is tr E = 0 a constant volume: a bar that is pressed loses volume, and E₁₁ > −½ bounds the work, by ½ σ_y a volume in
//! perfect plasticity. The force on it falls as it shortens, and so the first row of elements of a bar that hits a wall hard
//! takes all of the flow and is pressed to nothing (`a_green_naghdi_bar_is_pressed_to_nothing_by_finite_work`).
//!
//! The update works on S alone: exactly objective for any step, and the stress power is ½ (S_n + S_{n+1}) : (E_{n+1} − E_n),
//! which is the change of ½ S : (E − E_p) and the dissipation exactly.
//!
//! The source prints the yield stress of its example as 260 GPa and the stresses of its figures in GPa (dV 7.102, figures
//! 7.9 to 7.14); it is 260 MPa, and MPa, with E = 200 GPa and a yield strain of 0.0013.
//!
//! Parameters: elasticity, isotropic hardening. History: E, E_p, ε̄ᵖ, and T, which depends on F as well.

use crate::e_star::von_mises;
use crate::elastic::stress_power;
use crate::point_state;
use crate::return_mapping::{RadialReturn, radial_hardening_index};
use crate::tangent_bound::second_piola_kirchhoff;
use crate::{
    FlowStart, IsotropicElasticity, IsotropicHardening, Material, MaterialUpdate, ReferenceMotion, YieldCriterion,
};
use estar_tensor::{Mask, Real, Rotation, SymmetricTensor, Tensor};

/// The Green-Naghdi theory.
#[derive(Clone, Debug, PartialEq)]
pub struct GreenNaghdi {
    elasticity: IsotropicElasticity,
    hardening: IsotropicHardening,
}

/// History of [`GreenNaghdi`].
#[derive(Clone, Copy, Debug)]
pub struct GreenNaghdiState<R> {
    /// Green's strain E.
    pub strain: SymmetricTensor<R>,
    /// Plastic strain E_p, tr = 0.
    pub plastic_strain: SymmetricTensor<R>,
    /// Equivalent plastic strain ε̄ᵖ.
    pub equivalent_plastic_strain: R,
    /// Cauchy stress T, Pa.
    pub stress: SymmetricTensor<R>,
}

point_state!(GreenNaghdiState {
    strain: symmetric,
    plastic_strain: symmetric,
    equivalent_plastic_strain: number,
    stress: symmetric,
});

impl GreenNaghdi {
    /// The material with these parameters.
    pub fn new(elasticity: IsotropicElasticity, hardening: IsotropicHardening) -> Self {
        Self { elasticity, hardening }
    }

    /// S = 2μ dev(E − E_p) + k tr(E − E_p) I, Pa.
    #[inline(always)]
    pub fn second_piola_kirchhoff<R: Real>(
        &self,
        strain: &SymmetricTensor<R>,
        plastic_strain: &SymmetricTensor<R>,
    ) -> SymmetricTensor<R> {
        let difference = *strain - *plastic_strain;
        let spherical = difference.trace() * self.elasticity.lame_lambda();
        (difference * R::splat(2.0 * self.elasticity.shear_modulus())).plus_spherical(spherical)
    }
}

/// E = ½ (FᵀF − I).
#[inline(always)]
fn green_strain<R: Real>(gradient: &Tensor<R>) -> SymmetricTensor<R> {
    let stretch_squared = SymmetricTensor::spherical(R::splat(1.0)).pulled_by(gradient);
    stretch_squared.plus_spherical(R::splat(-1.0)) * R::splat(0.5)
}

impl Material for GreenNaghdi {
    type State<R: Real> = GreenNaghdiState<R>;

    type Motion<R: Real> = ReferenceMotion<R>;

    fn elasticity(&self) -> &IsotropicElasticity {
        &self.elasticity
    }

    /// The elasticity is that of S, pushed forward by F.
    #[inline(always)]
    fn stiffening<R: Real>(&self, state: &GreenNaghdiState<R>, motion: &ReferenceMotion<R>) -> Option<R> {
        let gradient = &motion.deformation_gradient;
        let jacobian = gradient.determinant();
        let metric = SymmetricTensor::spherical(R::splat(1.0)).pushed_by(gradient);
        let tangent = second_piola_kirchhoff(&self.elasticity, &(state.stress * jacobian), &metric);
        Some(tangent.over_rest(&self.elasticity) / jacobian)
    }

    fn initial_state<R: Real>(&self) -> GreenNaghdiState<R> {
        GreenNaghdiState {
            strain: SymmetricTensor::zero(),
            plastic_strain: SymmetricTensor::zero(),
            equivalent_plastic_strain: R::splat(0.0),
            stress: SymmetricTensor::zero(),
        }
    }

    #[inline(always)]
    fn update<R: Real>(
        &self,
        old: &GreenNaghdiState<R>,
        motion: &ReferenceMotion<R>,
        time_step: f64,
    ) -> MaterialUpdate<R, GreenNaghdiState<R>> {
        let gradient = &motion.deformation_gradient;
        let stress_old = self.second_piola_kirchhoff(&old.strain, &old.plastic_strain);
        let strain_old = old.equivalent_plastic_strain;

        // (i) elastic predictor: S_trial = 2μ dev(E_{n+1} − E_p,n) + k tr(E_{n+1}) I, E = ½ (FᵀF − I)
        let strain = green_strain(gradient);
        let trial = self.second_piola_kirchhoff(&strain, &old.plastic_strain);

        // (ii) admissibility: √(3/2) ‖dev S_trial‖ ≤ σ_y(ε̄ᵖ_n)
        let deviator = trial.deviator();
        let equivalent_stress = von_mises(&deviator);
        let start = FlowStart::new(strain_old, (), time_step);
        let law = RadialReturn { elasticity: &self.elasticity, hardening: &self.hardening, start };
        let flow_stress_old = law.flow_stress_old();
        let yields = equivalent_stress.gt(flow_stress_old.stress);

        // (iii) return mapping: ΔE_p = (3/2) p dev S_trial/(√(3/2) ‖dev S_trial‖)
        let (mut flow, mut increment) = (SymmetricTensor::zero(), R::splat(0.0));
        if yields.any() {
            increment = law.plastic_increment(yields, equivalent_stress, flow_stress_old);
            let safe_stress = R::select(yields, equivalent_stress, R::splat(1.0));
            flow = (deviator * (increment * 1.5 / safe_stress)).or_zero(yields);
        }
        let plastic_strain = old.plastic_strain + flow;
        let stress = self.second_piola_kirchhoff(&strain, &plastic_strain);

        let per_volume_half = motion.volume_half.recip();
        MaterialUpdate {
            state: GreenNaghdiState {
                strain,
                plastic_strain,
                equivalent_plastic_strain: strain_old + increment,
                // T = F S Fᵀ/J
                stress: stress.pushed_by(gradient) * gradient.determinant().recip(),
            },
            internal_energy: stress_power(&stress_old, &stress, &(strain - old.strain)) * per_volume_half,
            plastic_dissipation: stress_power(&stress_old, &stress, &flow).max(R::splat(0.0)) * per_volume_half,
        }
    }

    #[inline(always)]
    fn equivalent_plastic_strain<R: Real>(&self, state: &GreenNaghdiState<R>) -> R {
        state.equivalent_plastic_strain
    }

    #[inline(always)]
    fn cauchy_stress<R: Real>(&self, state: &GreenNaghdiState<R>, _: Rotation<R>) -> SymmetricTensor<R> {
        state.stress
    }

    /// C_p = I + 2 E_p.
    fn plastic_metric(&self, state: &GreenNaghdiState<f64>, _: &SymmetricTensor<f64>) -> SymmetricTensor<f64> {
        (state.plastic_strain * 2.0).plus_spherical(1.0)
    }

    /// tr E_p = 0 is not det C_p = 1.
    fn keeps_volume(&self) -> bool {
        false
    }

    /// Φ = H/(3μ + H).
    fn hardening_index(&self, state: &GreenNaghdiState<f64>, _: &Tensor<f64>) -> Option<f64> {
        Some(radial_hardening_index(&self.elasticity, self.hardening.at(state.equivalent_plastic_strain).slope))
    }

    /// √(3/2) ‖dev S‖.
    fn yield_criterion(&self, state: &GreenNaghdiState<f64>, motion: &ReferenceMotion<f64>) -> Option<YieldCriterion> {
        let trial = self.second_piola_kirchhoff(&green_strain(&motion.deformation_gradient), &state.plastic_strain);
        let strain = state.equivalent_plastic_strain;
        YieldCriterion::under(&self.hardening, strain, &(), von_mises(&trial.deviator()))
    }
}
