//! The kernels alone: rotation of the polar decomposition, update of each material, step of each element, for each set of
//! vector instructions.
//!
//! Measured: time per quadrature point, for the elements per element, of data in the first-level cache and in the motion of
//! the bar's foot, where every point yields. Not measured: gathering, forces to memory, node sums, histories that come from
//! memory, packs in which only some lanes yield.

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, criterion_group, criterion_main};
use estar::bench::single_hex::{Pace, STEPS_BEFORE, SingleElement};
use estar::bench::taylor_bar::{ELEMENTS, materials};
use estar_deck::model::element_name;
use estar_element::element::{Element, ElementVisitor};
use estar_material::{
    ClosestPoint, ElasticConstant, IsotropicElasticity, Material, MaterialModel, MaterialVisitor, Motion,
    ParameterError, StepKinematics,
};
use estar_solver::LaneLevel;
use estar_tensor::{Kernel, Real, Rotation, Tensor, WithLanes, dispatch};
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Packs of lanes that are worked on in turn: independent, and all in the first-level cache.
const PACKS: usize = 4;
/// Rounds over the packs between two looks at the clock.
const ROUNDS: usize = 500;
/// The same for an element, whose steps deform it.
const ELEMENT_ROUNDS: usize = 100;

/// The length of a step of the bar's foot, s.
const TIME_STEP: f64 = 2e-8;

/// Seconds of each of `count` things that were begun at `begun`.
fn each(begun: Instant, count: usize) -> f64 {
    begun.elapsed().as_secs_f64() / count as f64
}

/// The deformation gradient of the foot: compression, shear and a turn by `angle` (rad).
fn deformation_gradient<R: Real>(angle: f64) -> Tensor<R> {
    let turn = Rotation::about([0.3, -0.5, 0.8], angle).to_tensor();
    let stretch = Tensor::from_rows([[1.2, 0.1, 0.0], [0.1, 1.1, -0.1], [0.0, -0.1, 0.75]]);
    Tensor { columns: turn.dot(&stretch).columns.map(|column| estar_tensor::Vector3(column.0.map(R::splat))) }
}

/// Seconds of a polar decomposition whose guess is `angle` (rad) off.
struct PolarTime {
    angle: f64,
}

struct PolarRun<'a, R>(&'a [(Tensor<R>, Rotation<R>); PACKS]);

impl WithLanes for PolarTime {
    type Output = f64;

    fn with_lanes<R: Real>(self) -> f64 {
        let input = [(deformation_gradient::<R>(self.angle), Rotation::identity()); PACKS];
        let begun = Instant::now();
        for _ in 0..ROUNDS {
            R::vectorize(PolarRun(black_box(&input)));
        }
        each(begun, ROUNDS * PACKS * R::LANES)
    }
}

impl<R: Real> Kernel for PolarRun<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (gradient, guess) in self.0 {
            black_box(Rotation::nearest(gradient, *guess));
        }
    }
}

/// Seconds of an update of a material that yields.
struct UpdateTime<'a, M>(&'a M);

struct UpdateRun<'a, M: Material, R: Real> {
    material: &'a M,
    old: [M::State<R>; PACKS],
    step: StepKinematics<R>,
}

impl<M: Material> WithLanes for UpdateTime<'_, M> {
    type Output = f64;

    fn with_lanes<R: Real>(self) -> f64 {
        let rows = [[5e-4, 2e-4, 0.0], [-2e-4, 5e-4, 1e-4], [0.0, 1e-4, -1e-3]];
        let mut run = UpdateRun {
            material: self.0,
            old: [self.0.initial_state(); PACKS],
            step: StepKinematics {
                incremental_displacement_gradient: Tensor::from_rows(rows.map(|row| row.map(R::splat))),
                deformation_gradient: Tensor::identity(),
                rotation_old: Rotation::identity(),
                rotation_new: Rotation::identity(),
            },
        };
        for _ in 0..STEPS_BEFORE {
            run.old = R::vectorize(&run);
            // F ← F + Δt L F
            let gradient = run.step.deformation_gradient;
            run.step.deformation_gradient = gradient + run.step.incremental_displacement_gradient.dot(&gradient);
        }
        let begun = Instant::now();
        for _ in 0..ROUNDS {
            black_box(R::vectorize(black_box(&run)));
        }
        each(begun, ROUNDS * PACKS * R::LANES)
    }
}

impl<M: Material, R: Real> Kernel for &UpdateRun<'_, M, R> {
    type Output = [M::State<R>; PACKS];

    #[inline(always)]
    fn run(self) -> [M::State<R>; PACKS] {
        let mut states = self.old;
        for state in &mut states {
            *state = self.material.update(state, &M::Motion::new(&self.step), TIME_STEP).state;
            black_box(self.material.cauchy_stress(state, self.step.rotation_new));
        }
        states
    }
}

/// Seconds of a step of an element whose points yield.
struct AdvanceTime<'a> {
    material: &'a MaterialModel,
    level: LaneLevel,
}

impl ElementVisitor for AdvanceTime<'_> {
    type Output = f64;

    fn visit<const NODES: usize, E: Element<NODES>>(self, element: E) -> f64 {
        dispatch(self.level, AdvanceElement::<_, NODES> { material: self.material, element })
    }
}

struct AdvanceElement<'a, E, const NODES: usize> {
    material: &'a MaterialModel,
    element: E,
}

impl<E: Element<NODES>, const NODES: usize> WithLanes for AdvanceElement<'_, E, NODES> {
    type Output = f64;

    fn with_lanes<R: Real>(self) -> f64 {
        let new = || SingleElement::<E, R, NODES>::new(self.material, self.element, Pace::Yielding);
        let mut hexes: [_; PACKS] = std::array::from_fn(|_| new());
        let mut advance = |rounds| {
            for _ in 0..rounds {
                for hex in &mut hexes {
                    black_box(hex.advance());
                }
            }
        };
        advance(STEPS_BEFORE);
        let begun = Instant::now();
        advance(ELEMENT_ROUNDS);
        each(begun, ELEMENT_ROUNDS * PACKS * R::LANES)
    }
}

/// Enters a benchmark: `seconds` measures one of what an iteration is.
fn enter(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, seconds: impl Fn() -> f64) {
    group.bench_function(name, |bencher| {
        bencher.iter_custom(|iterations| Duration::from_secs_f64(seconds() * iterations as f64));
    });
}

/// Seconds of an update of one material with the instructions of one level.
struct TimeOfUpdate(LaneLevel);

impl MaterialVisitor for TimeOfUpdate {
    type Output = f64;

    fn visit<M: Material>(self, material: &M) -> f64 {
        dispatch(self.0, UpdateTime(material))
    }
}

/// Seconds of a closest-point return of principal stresses.
struct ReturnTime<'a>(&'a ClosestPoint);

struct ReturnRun<'a, R> {
    surface: &'a ClosestPoint,
    trials: [[R; 3]; PACKS],
}

impl WithLanes for ReturnTime<'_> {
    type Output = f64;

    fn with_lanes<R: Real>(self) -> f64 {
        let run = ReturnRun { surface: self.0, trials: [[900e6, 300e6, -400e6].map(R::splat); PACKS] };
        let begun = Instant::now();
        for _ in 0..ROUNDS {
            black_box(R::vectorize(black_box(&run)));
        }
        each(begun, ROUNDS * PACKS * R::LANES)
    }
}

impl<R: Real> Kernel for &ReturnRun<'_, R> {
    type Output = [[R; 3]; PACKS];

    #[inline(always)]
    fn run(self) -> [[R; 3]; PACKS] {
        let mut points = self.trials;
        for point in &mut points {
            *point = self.surface.returned(*point);
        }
        points
    }
}

/// The surfaces of the closest-point return.
fn surfaces() -> Result<[(&'static str, ClosestPoint); 4], ParameterError> {
    let constants = (ElasticConstant::YoungModulus(200e9), ElasticConstant::PoissonRatio(0.3));
    let solid = IsotropicElasticity::new(7850.0, constants.0, constants.1)?;
    Ok([
        ("closest point, von Mises", ClosestPoint::von_mises(solid, 260e6)?),
        ("closest point, Drucker-Prager", ClosestPoint::drucker_prager(solid, 0.5, 260e6, 0.2)?),
        ("closest point, Rankine", ClosestPoint::rankine(solid, 260e6)?),
        ("closest point, Mohr-Coulomb", ClosestPoint::mohr_coulomb(solid, 0.5, 260e6)?),
    ])
}

fn kernels(criterion: &mut Criterion) {
    for level in LaneLevel::ALL.into_iter().filter(|level| level.is_available()).rev() {
        let mut group = criterion.benchmark_group(format!("kernel, {}", level.name()));
        group.sample_size(20).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(1));
        for (name, angle) in [("polar, guess of the last step", 1e-4), ("polar, guess 60 degrees off", 1.05)] {
            enter(&mut group, name, || dispatch(level, PolarTime { angle }));
        }
        for (name, surface) in &surfaces().expect("valid parameters") {
            enter(&mut group, name, || dispatch(level, ReturnTime(surface)));
        }
        for (name, material) in materials() {
            enter(&mut group, &format!("update, {name}"), || material.visit(TimeOfUpdate(level)));
            for element in ELEMENTS {
                let time = || element.visit(AdvanceTime { material: &material, level });
                enter(&mut group, &format!("{}, {name}", element_name(element)), time);
            }
        }
        group.finish();
    }
}

criterion_group!(benches, kernels);
criterion_main!(benches);
