//! Goal: every lane of every level ends in the bits of the `f64` code, for each operation that physics uses.

use estar_tensor::{Kernel, LaneLevel, Mask, Real, Rotation, SymmetricTensor, Tensor, WithLanes, dispatch};

const COUNT: usize = 64;

/// Numbers of all sizes from a small linear congruential generator.
fn inputs() -> Vec<[f64; 9]> {
    let mut seed = 0x2545_F491_4F6C_DD1D_u64;
    let mut next = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let mut sets: Vec<[f64; 9]> = (0..COUNT).map(|_| std::array::from_fn(|_| next())).collect();
    for set in &mut sets {
        for i in [0, 4, 8] {
            set[i] += 1.5;
        }
    }
    // equal principal values, a pure rotation, a lane that is not a number
    sets[3] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    sets[5] = [0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    sets[7] = [f64::NAN; 9];
    sets
}

fn computed<R: Real>(input: &[R; 9]) -> Vec<R> {
    let [a, b, c, d, e, f, g, h, i] = *input;
    let tensor = Tensor::from_rows([[a, b, c], [d, e, f], [g, h, i]]);
    let mut out = vec![
        a + b,
        a - b,
        a * b,
        a / e,
        -a,
        a.mul_add(b, c),
        a.abs().sqrt(),
        b.abs(),
        a.max(b),
        a.min(b),
        (a * 100.0).round(),
        (a * 30.0).exp(),
        (a.abs() + 1e-3).ln(),
        (a.abs() + 1e-3).cbrt(),
        R::select(a.lt(b) & !c.le(d) | e.gt(f), a, b),
        tensor.determinant(),
        b + 1.0,
        b - 2.0,
        b * 3.0,
    ];
    let mut push = |t: Tensor<R>| out.extend(t.columns.iter().flat_map(|column| column.0));
    push(tensor.inverse());
    push(Rotation::nearest(&tensor, Rotation::identity()).to_tensor());
    let system = SymmetricTensor([a, b, c, d, e, f]).eigensystem();
    push(system.vectors);
    out.extend(system.values);
    out
}

struct Compute<'a, R>(&'a [R; 9]);

impl<R: Real> Kernel for Compute<'_, R> {
    type Output = Vec<R>;

    #[inline(always)]
    fn run(self) -> Vec<R> {
        computed(self.0)
    }
}

struct AllBits;

impl WithLanes for AllBits {
    type Output = Vec<Vec<u64>>;

    fn with_lanes<R: Real>(self) -> Vec<Vec<u64>> {
        let inputs = inputs();
        let mut bits = vec![Vec::new(); COUNT];
        for start in (0..COUNT).step_by(R::LANES) {
            let pack: [R; 9] = std::array::from_fn(|k| R::from_lanes(|lane| inputs[start + lane][k]));
            for value in R::vectorize(Compute(&pack)) {
                for lane in 0..R::LANES {
                    let number = value.lane(lane);
                    // the sign and payload of a NaN are nobody's result
                    bits[start + lane].push(if number.is_nan() { u64::MAX } else { number.to_bits() });
                }
            }
        }
        bits
    }
}

#[test]
fn every_level_gives_the_bits_of_f64() {
    let scalar = dispatch(LaneLevel::Portable, AllBits);
    assert!(scalar[0].iter().any(|&bits| bits != u64::MAX));
    for level in LaneLevel::ALL {
        if level.is_available() {
            assert_eq!(dispatch(level, AllBits), scalar, "{level:?}");
        } else {
            eprintln!("{level:?} is not available on this machine: not compared");
        }
    }
}

#[test]
fn masks_see_every_lane() {
    struct Masks;
    impl WithLanes for Masks {
        type Output = ();
        fn with_lanes<R: Real>(self) {
            for lane in 0..R::LANES {
                let one = R::from_lanes(|l| if l == lane { 1.0 } else { 0.0 });
                assert!(one.gt(R::splat(0.5)).any());
                assert_eq!(one.gt(R::splat(0.5)).all(), R::LANES == 1);
                assert!(one.is_finite().all());
                assert!(!(one / R::splat(0.0)).is_finite().all());
            }
        }
    }
    for level in LaneLevel::ALL {
        dispatch(level, Masks);
    }
}

struct Moved<'a> {
    rows: &'a [[f64; 4]],
    indices: &'a [u16],
    stride: usize,
}

struct MovedBy<'a, R>(Moved<'a>, std::marker::PhantomData<R>);

impl<R: Real> Kernel for MovedBy<'_, R> {
    type Output = Vec<[f64; 4]>;

    #[inline(always)]
    fn run(self) -> Vec<[f64; 4]> {
        let Moved { rows, indices, stride } = self.0;
        let mut moved = vec![[7.0; 4]; stride * (indices.len() - 1) + 1];
        for (pack, indices) in indices.chunks(R::LANES).enumerate() {
            let [_, second]: [_; 2] = R::gather(rows, indices);
            R::scatter(second, &mut moved[pack * R::LANES * stride..], stride);
        }
        moved
    }
}

impl WithLanes for Moved<'_> {
    type Output = Vec<[f64; 4]>;

    fn with_lanes<R: Real>(self) -> Vec<[f64; 4]> {
        R::vectorize(MovedBy::<R>(self, std::marker::PhantomData))
    }
}

/// Of two rows to an index the second is moved; rows end with the last lane's on either side.
#[test]
fn vectors_arrive_in_the_rows_of_their_lanes_from_any_row() {
    let rows: Vec<[f64; 4]> = (0..18).map(f64::from).map(|i| [i + 0.1, i + 0.2, i + 0.3, f64::NAN]).collect();
    for indices in [[0, 1, 2, 3, 4, 5, 6, 7], [8, 7, 6, 5, 4, 3, 2, 1], [3, 3, 8, 8, 0, 3, 0, 8]] {
        for stride in [1, 3, 8] {
            for level in LaneLevel::ALL {
                let moved = dispatch(level, Moved { rows: &rows, indices: &indices, stride });
                for (place, row) in moved.iter().enumerate() {
                    let vector = |lane: usize| rows[2 * indices[lane] as usize + 1];
                    let expected = if place % stride == 0 {
                        let [x, y, z, _] = vector(place / stride);
                        [x, y, z, 0.0]
                    } else {
                        [7.0; 4]
                    };
                    assert_eq!(*row, expected, "{indices:?}, stride {stride}, {level:?}, row {place}");
                }
            }
        }
    }
}

#[test]
fn an_index_beyond_the_rows_is_refused_at_every_level() {
    let rows = [[0.0; 4]; 17];
    for level in LaneLevel::ALL {
        let moved = |last| {
            let indices = [0, 1, 2, 3, 4, 5, 6, last];
            std::panic::catch_unwind(|| dispatch(level, Moved { rows: &rows, indices: &indices, stride: 1 }))
        };
        assert!(moved(7).is_ok() && moved(8).is_err() && moved(u16::MAX).is_err(), "{level:?}");
    }
}
