//! The seam between a theory and what drives it.

use crate::yield_criterion::YieldCriterion;
use crate::{
    ClosestPoint, EStar, EStarTotal, Elastic, GreenNaghdi, Hencky, Hypoelastic, IsotropicElasticity,
    IsotropicHardening, JohnsonCook, KinematicHardening, Motion, ObjectiveRate, PlasticMetric, Rankine, VonMises,
};
use estar_tensor::{Real, Rotation, SymmetricTensor, Tensor};

/// A constitutive theory with its parameters.
pub trait Material: Clone + Send + Sync + 'static {
    /// History at one quadrature point.
    type State<R: Real>: PointState<R>;

    /// What the theory is told of the motion.
    type Motion<R: Real>: Motion<R>;

    /// Density and elastic constants. They bound the stable time step, with [`Material::stiffening`].
    fn elasticity(&self) -> &IsotropicElasticity;

    /// Upper bound of the elastic tangent in the current configuration, the stiffness of the stress included, over that of
    /// [`Material::elasticity`], for a theory whose tangent grows with deformation: after an update by `motion` to `state`.
    /// Without it the stable time step holds for stresses that are small beside the moduli. Implementations are
    /// `#[inline(always)]`.
    #[inline(always)]
    fn stiffening<R: Real>(&self, _state: &Self::State<R>, _motion: &Self::Motion<R>) -> Option<R> {
        None
    }

    /// History of the undeformed, stress-free material.
    fn initial_state<R: Real>(&self) -> Self::State<R>;

    /// History at t_{n+1} after the motion of one step of length `time_step` (s) from the history `old`.
    ///
    /// Same inputs, same outputs; `old` is never changed. Implementations are `#[inline(always)]`.
    fn update<R: Real>(
        &self,
        old: &Self::State<R>,
        motion: &Self::Motion<R>,
        time_step: f64,
    ) -> MaterialUpdate<R, Self::State<R>>;

    /// Cauchy stress T of a history, Pa, where R is the `rotation`. Implementations are `#[inline(always)]`.
    fn cauchy_stress<R: Real>(&self, state: &Self::State<R>, rotation: Rotation<R>) -> SymmetricTensor<R>;

    /// ε̄ᵖ of a history. Implementations are `#[inline(always)]`.
    fn equivalent_plastic_strain<R: Real>(&self, state: &Self::State<R>) -> R;

    /// Plastic metric C_p = U_p² of a history, where `metric` is C = FᵀF: what is told of a point, no part of a step.
    fn plastic_metric(&self, state: &Self::State<f64>, metric: &SymmetricTensor<f64>) -> SymmetricTensor<f64>;

    /// Φ = f̂/ĝ of a history that flows (de Vera 2016, eq. 3.28-3.30), where F is the `deformation_gradient`: positive where
    /// the material hardens, zero where it is perfectly plastic, negative where it softens. None where it cannot flow, or
    /// where there is no closed form.
    fn hardening_index(&self, state: &Self::State<f64>, deformation_gradient: &Tensor<f64>) -> Option<f64>;

    /// Where the elastic predictor of a step from the history `state` leads, and how far it may. None where the material cannot
    /// flow, or where more than this decides whether it does.
    fn yield_criterion(&self, _state: &Self::State<f64>, _motion: &Self::Motion<f64>) -> Option<YieldCriterion> {
        None
    }

    /// Temperature of a history, K, of a material that has one. Implementations are `#[inline(always)]`.
    #[inline(always)]
    fn temperature<R: Real>(&self, _state: &Self::State<R>) -> Option<R> {
        None
    }

    /// The share of the plastic dissipation that heats the material, where it has a temperature.
    fn heat_share(&self) -> Option<f64> {
        None
    }

    /// Whether plastic flow keeps the volume.
    fn keeps_volume(&self) -> bool {
        true
    }

    /// Why no element can have this material; none where elements can.
    fn obstacle_to_elements(&self) -> Option<&'static str> {
        None
    }
}

/// The numbers of a history, in one fixed order: for hashes, for files, for copies from lane to lane.
pub trait PointState<R: Real>: Copy + Send + Sync + 'static {
    /// Calls `visit` with every number.
    fn for_each(&self, visit: impl FnMut(R));

    /// The history whose numbers `next` gives in the order of [`PointState::for_each`].
    fn from_numbers(next: impl FnMut() -> R) -> Self;

    /// `chosen` where the mask is set, else `otherwise`.
    fn select(mask: R::Mask, chosen: &Self, otherwise: &Self) -> Self;
}

impl<R: Real> PointState<R> for () {
    fn for_each(&self, _: impl FnMut(R)) {}

    fn from_numbers(_: impl FnMut() -> R) -> Self {}

    fn select(_: R::Mask, (): &Self, (): &Self) -> Self {}
}

/// Implements [`PointState`] for a history from the order of its fields, each a `number`, a `tensor`, a `symmetric` tensor
/// or an `inner` history, whose type is a parameter.
#[macro_export]
macro_rules! point_state {
    ($state:ident $(<$($inner:ident),+>)? { $($field:ident: $kind:ident),+ $(,)? }) => {
        impl<R: ::estar_tensor::Real $($(, $inner: $crate::PointState<R>)+)?> $crate::PointState<R>
            for $state<R $($(, $inner)+)?>
        {
            #[inline]
            fn for_each(&self, mut visit: impl FnMut(R)) {
                $($crate::point_state!(@visit $kind self.$field, visit);)+
            }

            #[inline]
            fn from_numbers(mut next: impl FnMut() -> R) -> Self {
                $state { $($field: $crate::point_state!(@make $kind next)),+ }
            }

            #[inline]
            fn select(mask: R::Mask, chosen: &Self, otherwise: &Self) -> Self {
                $state { $($field: $crate::point_state!(@select $kind mask, chosen.$field, otherwise.$field)),+ }
            }
        }
    };
    (@visit number $value:expr, $visit:ident) => { $visit($value) };
    (@visit tensor $value:expr, $visit:ident) => {
        $value.columns.into_iter().flat_map(|column| column.0).for_each(&mut $visit)
    };
    (@visit symmetric $value:expr, $visit:ident) => { $value.0.into_iter().for_each(&mut $visit) };
    (@visit inner $value:expr, $visit:ident) => { $crate::PointState::for_each(&$value, &mut $visit) };
    (@make number $next:ident) => { $next() };
    (@make tensor $next:ident) => {
        ::estar_tensor::Tensor {
            columns: ::std::array::from_fn(|_| ::estar_tensor::Vector3(::std::array::from_fn(|_| $next()))),
        }
    };
    (@make symmetric $next:ident) => { ::estar_tensor::SymmetricTensor(::std::array::from_fn(|_| $next())) };
    (@make inner $next:ident) => { $crate::PointState::from_numbers(&mut $next) };
    (@select number $mask:ident, $chosen:expr, $otherwise:expr) => { R::select($mask, $chosen, $otherwise) };
    (@select tensor $mask:ident, $chosen:expr, $otherwise:expr) => {
        ::estar_tensor::Tensor {
            columns: ::std::array::from_fn(|j| ::estar_tensor::Vector3(::std::array::from_fn(|i| {
                R::select($mask, $chosen.columns[j].0[i], $otherwise.columns[j].0[i])
            }))),
        }
    };
    (@select symmetric $mask:ident, $chosen:expr, $otherwise:expr) => {
        ::estar_tensor::SymmetricTensor::select($mask, &$chosen, &$otherwise)
    };
    (@select inner $mask:ident, $chosen:expr, $otherwise:expr) => {
        $crate::PointState::select($mask, &$chosen, &$otherwise)
    };
}

/// What an update gives back.
#[derive(Clone, Copy, Debug)]
pub struct MaterialUpdate<R, State> {
    /// History at t_{n+1}.
    pub state: State,
    /// Stress power of the step ∫ T : D dt by the trapezoidal rule, J per m³ of the mid-step volume.
    pub internal_energy: R,
    /// The part of it that plastic flow dissipates, by the same rule, J/m³: ∫ T : D_p dt less the change of the energy that a
    /// moving centre of the yield surface stores. The other part is that change and the change of the elastic energy.
    pub plastic_dissipation: R,
}

/// Every material that elements and the point driver can have. A line a theory: the one that a new theory adds.
macro_rules! materials {
    ($($(#[doc = $doc:literal])+ $name:ident($material:ty),)+) => {
        /// A material, whichever its theory; made from that by [`From`].
        #[derive(Clone, Debug, PartialEq)]
        pub enum MaterialModel {
            $($(#[doc = $doc])+ $name($material),)+
        }

        impl MaterialModel {
            /// Hands the theory to the visitor: the way to all that is the same for every theory.
            pub fn visit<V: MaterialVisitor>(&self, visitor: V) -> V::Output {
                match self {
                    $(Self::$name(material) => visitor.visit(material),)+
                }
            }
        }

        $(impl From<$material> for MaterialModel {
            fn from(material: $material) -> Self {
                Self::$name(material)
            }
        })+
    };
}

materials! {
    /// Isotropic elasticity in rate form with the box rate.
    Elastic(Elastic),
    /// Isotropic elasticity in rate form with another objective rate.
    Hypoelastic(Hypoelastic),
    /// E* theory, box-rate update, isotropic hardening.
    EStar(EStar<(), IsotropicHardening>),
    /// E* theory, box-rate update, isotropic and kinematic hardening.
    EStarKinematic(EStar<KinematicHardening, IsotropicHardening>),
    /// E* theory, box-rate update, hardening with rate and temperature.
    EStarJohnsonCook(EStar<(), JohnsonCook>),
    /// E* theory, total update.
    EStarTotal(EStarTotal<IsotropicHardening>),
    /// E* theory, total update, hardening with rate and temperature.
    EStarTotalJohnsonCook(EStarTotal<JohnsonCook>),
    /// Green-Naghdi Lagrangian theory.
    GreenNaghdi(GreenNaghdi),
    /// Hencky hyperelasticity that yields by von Mises.
    Hencky(Hencky<VonMises<IsotropicHardening>>),
    /// Hencky hyperelasticity that yields by von Mises, hardening with rate and temperature.
    HenckyJohnsonCook(Hencky<VonMises<JohnsonCook>>),
    /// Hencky hyperelasticity that yields by Rankine.
    HenckyRankine(Hencky<Rankine>),
    /// Hencky hyperelasticity that yields perfectly by any surface of the closest-point return.
    HenckyClosestPoint(Hencky<ClosestPoint>),
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
    /// Isotropic elasticity in rate form with any objective rate; the box rate has an update of its own.
    pub fn hypoelastic(elasticity: IsotropicElasticity, rate: ObjectiveRate) -> Self {
        match rate {
            ObjectiveRate::Box => Elastic::new(elasticity).into(),
            rate => Hypoelastic::new(elasticity, rate).into(),
        }
    }

    /// E* theory in the box-rate update; a yield surface that rests has an update of its own.
    pub fn e_star_box_rate(
        elasticity: IsotropicElasticity,
        hardening: IsotropicHardening,
        kinematic: KinematicHardening,
    ) -> Self {
        if kinematic.is_active() {
            EStar::new(elasticity, hardening, kinematic).into()
        } else {
            EStar::new(elasticity, hardening, ()).into()
        }
    }

    /// Density and elastic constants.
    pub fn elasticity(&self) -> IsotropicElasticity {
        self.visit(ElasticityOf)
    }

    /// Why no element can have this material; none for those that elements can have.
    pub fn obstacle_to_elements(&self) -> Option<&'static str> {
        self.visit(ObstacleOf)
    }

    /// Whether plastic flow keeps the volume.
    pub fn keeps_volume(&self) -> bool {
        self.visit(KeepsVolume)
    }

    /// The share of the plastic dissipation that heats the material, where it has a temperature.
    pub fn heat_share(&self) -> Option<f64> {
        self.visit(HeatShare)
    }

    /// Whether the material has a temperature.
    pub fn has_temperature(&self) -> bool {
        self.heat_share().is_some()
    }
}

struct ElasticityOf;

impl MaterialVisitor for ElasticityOf {
    type Output = IsotropicElasticity;

    fn visit<M: Material>(self, material: &M) -> IsotropicElasticity {
        *material.elasticity()
    }
}

struct ObstacleOf;

impl MaterialVisitor for ObstacleOf {
    type Output = Option<&'static str>;

    fn visit<M: Material>(self, material: &M) -> Option<&'static str> {
        material.obstacle_to_elements()
    }
}

struct KeepsVolume;

impl MaterialVisitor for KeepsVolume {
    type Output = bool;

    fn visit<M: Material>(self, material: &M) -> bool {
        material.keeps_volume()
    }
}

struct HeatShare;

impl MaterialVisitor for HeatShare {
    type Output = Option<f64>;

    fn visit<M: Material>(self, material: &M) -> Option<f64> {
        material.heat_share()
    }
}
