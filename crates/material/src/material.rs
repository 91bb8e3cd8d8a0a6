//! The seam between a theory and what drives it.

use crate::{
    EStar, EStarTotal, Elastic, ElasticEnergy, FlowRule, GreenNaghdi, Hencky, HenckySurface, Hypoelastic,
    IsotropicElasticity, IsotropicHardening, KinematicHardening, Motion, ObjectiveRate, PlasticMetric,
};
use estar_tensor::{Real, Rotation, SymmetricTensor};

/// A constitutive theory with its parameters.
pub trait Material: Clone + Send + Sync + 'static {
    /// History at one quadrature point.
    type State<R: Real>: PointState<R>;

    /// What the theory is told of the motion.
    type Motion<R: Real>: Motion<R>;

    /// Density and elastic constants. They bound the stable time step, with [`Material::stiffening`].
    fn elasticity(&self) -> &IsotropicElasticity;

    /// Upper bound of the elastic tangent in the current configuration over that of [`Material::elasticity`], for a theory
    /// whose tangent grows with deformation. Implementations are `#[inline(always)]`.
    #[inline(always)]
    fn stiffening<R: Real>(&self, _motion: &Self::Motion<R>) -> Option<R> {
        None
    }

    /// History of the undeformed, stress-free material.
    fn initial_state<R: Real>(&self) -> Self::State<R>;

    /// History at t_{n+1} after the motion of one step from the history `old`.
    ///
    /// Same inputs, same outputs; `old` is never changed. Implementations are `#[inline(always)]`.
    fn update<R: Real>(&self, old: &Self::State<R>, motion: &Self::Motion<R>) -> MaterialUpdate<R, Self::State<R>>;

    /// Cauchy stress T of a history, Pa, where R is the `rotation`. Implementations are `#[inline(always)]`.
    fn cauchy_stress<R: Real>(&self, state: &Self::State<R>, rotation: Rotation<R>) -> SymmetricTensor<R>;

    /// ε̄ᵖ of a history. Implementations are `#[inline(always)]`.
    fn equivalent_plastic_strain<R: Real>(&self, state: &Self::State<R>) -> R;

    /// Plastic metric C_p = U_p² of a history, where `metric` is C = FᵀF: what is told of a point, no part of a step.
    fn plastic_metric(&self, state: &Self::State<f64>, metric: &SymmetricTensor<f64>) -> SymmetricTensor<f64>;

    /// Φ = f̂/ĝ of a history that flows (de Vera 2016, eq. 3.28-3.30): positive where the material hardens, zero where it
    /// is perfectly plastic, negative where it softens. None where it cannot flow.
    fn hardening_index(&self, state: &Self::State<f64>) -> Option<f64>;
}

/// The numbers of a history, in one fixed order: for hashes, for files, for copies from lane to lane.
pub trait PointState<R: Real>: Copy + Send + Sync + 'static {
    /// Calls `visit` with every number.
    fn for_each(&self, visit: impl FnMut(R));

    /// The history whose numbers `next` gives in the order of [`PointState::for_each`].
    fn from_numbers(next: impl FnMut() -> R) -> Self;
}

/// Implements [`PointState`] for a history from the order of its fields, each a number, a tensor or a symmetric tensor.
macro_rules! point_state {
    ($state:ident { $($field:ident: $kind:ident),+ $(,)? }) => {
        impl<R: estar_tensor::Real> $crate::PointState<R> for $state<R> {
            #[inline]
            fn for_each(&self, mut visit: impl FnMut(R)) {
                $($crate::material::point_state!(@visit $kind self.$field, visit);)+
            }

            #[inline]
            fn from_numbers(mut next: impl FnMut() -> R) -> Self {
                $state { $($field: $crate::material::point_state!(@make $kind next)),+ }
            }
        }
    };
    (@visit number $value:expr, $visit:ident) => { $visit($value) };
    (@visit tensor $value:expr, $visit:ident) => {
        $value.columns.into_iter().flat_map(|column| column.0).for_each(&mut $visit)
    };
    (@visit symmetric $value:expr, $visit:ident) => { $value.0.into_iter().for_each(&mut $visit) };
    (@make number $next:ident) => { $next() };
    (@make tensor $next:ident) => {
        estar_tensor::Tensor {
            columns: std::array::from_fn(|_| estar_tensor::Vector3(std::array::from_fn(|_| $next()))),
        }
    };
    (@make symmetric $next:ident) => { estar_tensor::SymmetricTensor(std::array::from_fn(|_| $next())) };
}
pub(crate) use point_state;

/// What an update gives back.
#[derive(Clone, Copy, Debug)]
pub struct MaterialUpdate<R, State> {
    /// History at t_{n+1}.
    pub state: State,
    /// Stress power of the step ∫ T : D dt by the trapezoidal rule, J per m³ of the mid-step volume.
    pub internal_energy: R,
    /// The part of it that plastic flow dissipates, ∫ (T − α) : D_p dt by the same rule, J/m³. With a centre α that rests
    /// the other part is the change of the elastic energy.
    pub plastic_dissipation: R,
}

/// Every material that a deck can name: one variant a theory.
#[derive(Clone, Debug)]
pub enum MaterialModel {
    /// Isotropic elasticity in rate form with the box rate.
    Elastic(Elastic),
    /// Isotropic elasticity in rate form with another objective rate.
    Hypoelastic(Hypoelastic),
    /// E* theory, box-rate update, isotropic hardening.
    EStar(EStar<()>),
    /// E* theory, box-rate update, isotropic and kinematic hardening.
    EStarKinematic(EStar<KinematicHardening>),
    /// E* theory, total update.
    EStarTotal(EStarTotal),
    /// Green-Naghdi Lagrangian theory.
    GreenNaghdi(GreenNaghdi),
    /// Hencky hyperelasticity with plasticity.
    Hencky(Hencky),
    /// Hyperelasticity with a flow rule for the plastic metric.
    PlasticMetric(PlasticMetric),
}

/// Work for [`MaterialModel::visit`], the same for every theory.
pub trait MaterialVisitor {
    /// What the work returns.
    type Output;

    /// Does the work with the theory of the model.
    fn visit<M: Material>(self, material: &M) -> Self::Output;
}

impl MaterialModel {
    /// Hands the theory to the visitor. This is the only place that tells one theory from another.
    pub fn visit<V: MaterialVisitor>(&self, visitor: V) -> V::Output {
        match self {
            Self::Elastic(material) => visitor.visit(material),
            Self::Hypoelastic(material) => visitor.visit(material),
            Self::EStar(material) => visitor.visit(material),
            Self::EStarKinematic(material) => visitor.visit(material),
            Self::EStarTotal(material) => visitor.visit(material),
            Self::GreenNaghdi(material) => visitor.visit(material),
            Self::Hencky(material) => visitor.visit(material),
            Self::PlasticMetric(material) => visitor.visit(material),
        }
    }

    /// Isotropic elasticity in rate form: T□ = 2μ dev D + k tr(D) I.
    pub fn elastic(elasticity: IsotropicElasticity) -> Self {
        Self::Elastic(Elastic::new(elasticity))
    }

    /// Isotropic elasticity in rate form, with any objective rate of the Cauchy stress.
    pub fn hypoelastic(elasticity: IsotropicElasticity, rate: ObjectiveRate) -> Self {
        match rate {
            ObjectiveRate::Box => Self::elastic(elasticity),
            rate => Self::Hypoelastic(Hypoelastic::new(elasticity, rate)),
        }
    }

    /// Why no element can have this material; none for those that elements can have.
    pub fn obstacle_to_elements(&self) -> Option<&'static str> {
        match self {
            Self::Hypoelastic(material) if !material.rate().is_corotational() => Some(
                "a rate that stretches with the material makes it stiffer as it is stretched, beyond what the bound of the \
                 stable time step knows; the rates box, jaumann and logarithmic can run",
            ),
            Self::PlasticMetric(material) => material.rule().fault(),
            _ => None,
        }
    }

    /// E* theory in the box-rate update.
    pub fn e_star_box_rate(
        elasticity: IsotropicElasticity,
        hardening: IsotropicHardening,
        kinematic: KinematicHardening,
    ) -> Self {
        if kinematic.is_active() {
            Self::EStarKinematic(EStar::new(elasticity, hardening, kinematic))
        } else {
            Self::EStar(EStar::new(elasticity, hardening, ()))
        }
    }

    /// E* theory in the total update.
    pub fn e_star_total(elasticity: IsotropicElasticity, hardening: IsotropicHardening) -> Self {
        Self::EStarTotal(EStarTotal::new(elasticity, hardening))
    }

    /// Green-Naghdi Lagrangian theory.
    pub fn green_naghdi(elasticity: IsotropicElasticity, hardening: IsotropicHardening) -> Self {
        Self::GreenNaghdi(GreenNaghdi::new(elasticity, hardening))
    }

    /// Hencky hyperelasticity with plasticity.
    pub fn hencky(elasticity: IsotropicElasticity, hardening: IsotropicHardening, surface: HenckySurface) -> Self {
        Self::Hencky(Hencky::new(elasticity, hardening, surface))
    }

    /// Hyperelasticity with a flow rule for the plastic metric.
    pub fn plastic_metric(
        elasticity: IsotropicElasticity,
        hardening: IsotropicHardening,
        energy: ElasticEnergy,
        rule: FlowRule,
    ) -> Self {
        Self::PlasticMetric(PlasticMetric::new(elasticity, hardening, energy, rule))
    }

    /// Density and elastic constants.
    pub fn elasticity(&self) -> IsotropicElasticity {
        self.visit(ElasticityOf)
    }
}

struct ElasticityOf;

impl MaterialVisitor for ElasticityOf {
    type Output = IsotropicElasticity;

    fn visit<M: Material>(self, material: &M) -> IsotropicElasticity {
        *material.elasticity()
    }
}
