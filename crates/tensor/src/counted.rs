//! A number that remembers how it was made, so that the arithmetic of a kernel can be counted.

use crate::elementary;
use crate::lanes::LaneLevel;
use crate::real::{Kernel, Mask, Real};
use std::cell::RefCell;
use std::collections::HashMap;
use std::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, Neg, Not, Sub, SubAssign};

/// Operations that a kernel cannot do without, of one lane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Operations {
    /// Additions and subtractions.
    pub additions: usize,
    /// Multiplications.
    pub multiplications: usize,
    /// Fused multiply-adds.
    pub fused: usize,
    /// Divisions.
    pub divisions: usize,
    /// Square roots.
    pub square_roots: usize,
    /// Comparisons, minima and maxima.
    pub comparisons: usize,
    /// Selections by a mask.
    pub selections: usize,
    /// Exponents, masks, rounding to integers. A change of sign is none: it is part of what uses it.
    pub others: usize,
}

impl Operations {
    /// Floating-point operations: a fused multiply-add is two, every other operation of arithmetic one; what only
    /// compares, selects or moves bits is none.
    pub fn flops(&self) -> usize {
        self.additions + self.multiplications + 2 * self.fused + self.divisions + self.square_roots
    }

    /// Instructions that it takes at least, a fused multiply-add being one.
    pub fn instructions(&self) -> usize {
        self.flops() - self.fused + self.comparisons + self.selections + self.others
    }
}

/// The operations that the numbers returned by `kernel`, and the branches taken in it, depend on.
///
/// It counts what a compiler has to leave: an operation is counted once, however often it is written with the same
/// operands; what no result needs is not counted, nor what follows from constants ([`Real::splat`]) alone, which is
/// computed before a loop. Numbers made outside of `kernel` are given. `exp` and its kind count as what they are made of.
pub fn operations(kernel: impl FnOnce() -> Vec<Counted>) -> Operations {
    TAPE.with_borrow_mut(Tape::open);
    let results = kernel();
    TAPE.with_borrow_mut(|tape| tape.close(&results))
}

/// An `f64` that [`operations`] counts the operations of.
#[derive(Clone, Copy, Debug)]
pub struct Counted {
    value: f64,
    origin: Origin,
}

/// The answer of a comparison of [`Counted`].
#[derive(Clone, Copy, Debug)]
pub struct CountedMask {
    value: bool,
    origin: Origin,
}

/// A number of its own for each value, but for those that are equal because the same was done to the same.
type Origin = u32;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Operation {
    Given,
    Constant,
    Add,
    Subtract,
    Multiply,
    Divide,
    Fuse,
    SquareRoot,
    Less,
    LessOrEqual,
    Larger,
    Smaller,
    Select,
    Negate,
    Absolute,
    Round,
    PowerOfTwo,
    Exponent,
    Mantissa,
    And,
    Or,
    Not,
}

/// An operation and where its operands come from; one with fewer than three repeats the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Step {
    operation: Operation,
    operands: [Origin; 3],
}

/// What a kernel did.
#[derive(Default)]
struct Tape {
    is_open: bool,
    /// Values made before the tape was opened: they are given.
    earlier: u32,
    steps: Vec<Step>,
    /// Whether a step follows from constants alone.
    is_constant: Vec<bool>,
    origins: HashMap<Step, Origin>,
    /// Masks that a branch was taken on.
    branches: Vec<Origin>,
}

thread_local! {
    static TAPE: RefCell<Tape> = RefCell::default();
}

impl Tape {
    fn open(&mut self) {
        *self = Self { is_open: true, earlier: self.earlier, ..Self::default() };
    }

    /// Position of the step that made a value, unless that is older than the tape.
    fn position(&self, origin: Origin) -> Option<usize> {
        origin.checked_sub(self.earlier).map(|position| position as usize)
    }

    fn is_constant(&self, origin: Origin) -> bool {
        self.position(origin).is_some_and(|position| self.is_constant[position])
    }

    fn enter(&mut self, step: Step, is_constant: bool) -> Origin {
        if !self.is_open {
            self.earlier += 1;
            return self.earlier - 1;
        }
        let next = self.next();
        let origin = *self.origins.entry(step).or_insert(next);
        if origin == next {
            self.steps.push(step);
            self.is_constant.push(is_constant);
        }
        origin
    }

    fn next(&self) -> Origin {
        self.earlier + self.steps.len() as u32
    }

    fn close(&mut self, results: &[Counted]) -> Operations {
        self.is_open = false;
        let mut needed = vec![false; self.steps.len()];
        let mut open = std::mem::take(&mut self.branches);
        open.extend(results.iter().map(|result| result.origin));
        let mut operations = Operations::default();
        while let Some(origin) = open.pop() {
            let Some(position) = self.position(origin) else { continue };
            let step = self.steps[position];
            let costs_nothing = self.is_constant[position] || step.operation == Operation::Given;
            if costs_nothing || std::mem::replace(&mut needed[position], true) {
                continue;
            }
            open.extend(step.operands);
            *match step.operation {
                Operation::Add | Operation::Subtract => &mut operations.additions,
                Operation::Multiply => &mut operations.multiplications,
                Operation::Fuse => &mut operations.fused,
                Operation::Divide => &mut operations.divisions,
                Operation::SquareRoot => &mut operations.square_roots,
                Operation::Less | Operation::LessOrEqual | Operation::Larger | Operation::Smaller => {
                    &mut operations.comparisons
                }
                Operation::Select => &mut operations.selections,
                Operation::Negate => continue,
                _ => &mut operations.others,
            } += 1;
        }
        self.earlier = self.next();
        operations
    }
}

fn enter(operation: Operation, operands: [Origin; 3]) -> Origin {
    TAPE.with_borrow_mut(|tape| {
        let is_constant = operands.iter().all(|&operand| tape.is_constant(operand));
        tape.enter(Step { operation, operands }, is_constant)
    })
}

/// The operands of a sum or a product in the order that makes equal ones equal.
fn sorted(a: Origin, b: Origin) -> [Origin; 2] {
    [a.min(b), a.max(b)]
}

impl Counted {
    fn unary(self, operation: Operation, value: f64) -> Self {
        Self { value, origin: enter(operation, [self.origin; 3]) }
    }

    fn binary(self, operation: Operation, other: Self, value: f64) -> Self {
        Self { value, origin: enter(operation, [self.origin, other.origin, other.origin]) }
    }

    fn commuting(self, operation: Operation, other: Self, value: f64) -> Self {
        let [a, b] = sorted(self.origin, other.origin);
        Self { value, origin: enter(operation, [a, b, b]) }
    }

    fn compared(self, operation: Operation, other: Self, value: bool) -> CountedMask {
        CountedMask { value, origin: enter(operation, [self.origin, other.origin, other.origin]) }
    }
}

impl Add for Counted {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.commuting(Operation::Add, other, self.value + other.value)
    }
}

impl Sub for Counted {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.binary(Operation::Subtract, other, self.value - other.value)
    }
}

impl Mul for Counted {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        self.commuting(Operation::Multiply, other, self.value * other.value)
    }
}

impl Div for Counted {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        self.binary(Operation::Divide, other, self.value / other.value)
    }
}

impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        self.unary(Operation::Negate, -self.value)
    }
}

impl Add<f64> for Counted {
    type Output = Self;
    fn add(self, other: f64) -> Self {
        self + Self::splat(other)
    }
}

impl Sub<f64> for Counted {
    type Output = Self;
    fn sub(self, other: f64) -> Self {
        self - Self::splat(other)
    }
}

impl Mul<f64> for Counted {
    type Output = Self;
    fn mul(self, other: f64) -> Self {
        self * Self::splat(other)
    }
}

impl AddAssign for Counted {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Counted {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Real for Counted {
    type Mask = CountedMask;

    const LANES: usize = 1;
    const LEVEL: LaneLevel = LaneLevel::Portable;

    fn splat(value: f64) -> Self {
        let bits = value.to_bits();
        let step = Step { operation: Operation::Constant, operands: [(bits >> 32) as u32, bits as u32, 0] };
        Self { value, origin: TAPE.with_borrow_mut(|tape| tape.enter(step, true)) }
    }

    fn from_lanes(mut value: impl FnMut(usize) -> f64) -> Self {
        let enter =
            |tape: &mut Tape| tape.enter(Step { operation: Operation::Given, operands: [tape.next(); 3] }, false);
        Self { value: value(0), origin: TAPE.with_borrow_mut(enter) }
    }

    fn lane(self, _lane: usize) -> f64 {
        self.value
    }

    fn store(self, target: &mut [f64]) {
        target[0] = self.value;
    }

    fn mul_add(self, factor: Self, addend: Self) -> Self {
        let [a, b] = sorted(self.origin, factor.origin);
        Self {
            value: f64::mul_add(self.value, factor.value, addend.value),
            origin: enter(Operation::Fuse, [a, b, addend.origin]),
        }
    }

    fn sqrt(self) -> Self {
        self.unary(Operation::SquareRoot, self.value.sqrt())
    }

    fn abs(self) -> Self {
        self.unary(Operation::Absolute, self.value.abs())
    }

    fn max(self, other: Self) -> Self {
        self.binary(Operation::Larger, other, Real::max(self.value, other.value))
    }

    fn min(self, other: Self) -> Self {
        self.binary(Operation::Smaller, other, Real::min(self.value, other.value))
    }

    fn round(self) -> Self {
        self.unary(Operation::Round, Real::round(self.value))
    }

    fn lt(self, other: Self) -> CountedMask {
        self.compared(Operation::Less, other, self.value < other.value)
    }

    fn le(self, other: Self) -> CountedMask {
        self.compared(Operation::LessOrEqual, other, self.value <= other.value)
    }

    fn select(mask: CountedMask, chosen: Self, otherwise: Self) -> Self {
        let selected = if mask.value { chosen } else { otherwise };
        let is_known = TAPE.with_borrow(|tape| tape.is_constant(mask.origin));
        if is_known || chosen.origin == otherwise.origin {
            return selected;
        }
        let origin = enter(Operation::Select, [mask.origin, chosen.origin, otherwise.origin]);
        Self { origin, ..selected }
    }

    fn power_of_two(self) -> Self {
        self.unary(Operation::PowerOfTwo, self.value.power_of_two())
    }

    fn exponent_and_mantissa(self) -> (Self, Self) {
        let (exponent, mantissa) = self.value.exponent_and_mantissa();
        (self.unary(Operation::Exponent, exponent), self.unary(Operation::Mantissa, mantissa))
    }

    fn vectorize<K: Kernel>(kernel: K) -> K::Output {
        kernel.run()
    }

    // functions of their own: the code that is counted need not be fast, but it must not be compiled at every place

    fn exp(self) -> Self {
        elementary::exp(self)
    }

    fn ln(self) -> Self {
        elementary::ln(self)
    }

    fn cbrt(self) -> Self {
        elementary::cbrt(self)
    }
}

impl CountedMask {
    fn joined(self, operation: Operation, other: Self, value: bool) -> Self {
        let [a, b] = sorted(self.origin, other.origin);
        Self { value, origin: enter(operation, [a, b, b]) }
    }
}

impl BitAnd for CountedMask {
    type Output = Self;
    fn bitand(self, other: Self) -> Self {
        self.joined(Operation::And, other, self.value & other.value)
    }
}

impl BitOr for CountedMask {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        self.joined(Operation::Or, other, self.value | other.value)
    }
}

impl Not for CountedMask {
    type Output = Self;
    fn not(self) -> Self {
        Self { value: !self.value, origin: enter(Operation::Not, [self.origin; 3]) }
    }
}

impl Mask for CountedMask {
    fn any(self) -> bool {
        TAPE.with_borrow_mut(|tape| tape.branches.push(self.origin));
        self.value
    }

    fn all(self) -> bool {
        TAPE.with_borrow_mut(|tape| tape.branches.push(self.origin));
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Tensor;

    fn given(value: f64) -> Counted {
        Counted::from_lanes(|_| value)
    }

    #[test]
    fn every_operation_is_counted_as_what_it_is() {
        let (a, b, c) = (given(2.0), given(3.0), given(5.0));
        let count = operations(|| {
            let sum = a + b;
            let fused = sum.mul_add(sum * c, c - a);
            let root = (fused / b).sqrt();
            vec![Real::max(root, a), Counted::select(a.lt(b), root, -a)]
        });
        let expected = Operations {
            additions: 2,
            multiplications: 1,
            fused: 1,
            divisions: 1,
            square_roots: 1,
            comparisons: 2,
            selections: 1,
            others: 0,
        };
        assert_eq!(count, expected);
        assert_eq!(count.flops(), 7);
        assert_eq!(count.instructions(), 9);
    }

    #[test]
    fn only_what_a_result_or_a_branch_needs_is_counted_and_only_once() {
        let (a, b) = (given(2.0), given(3.0));
        let count = operations(|| {
            let product = b * a;
            let _unused = product / b;
            // the same product; constants; a mask that is known
            let factor = Counted::splat(2.0) * 3.0 - 1.0;
            let known = Counted::splat(1.0).lt(Counted::splat(0.0));
            let same = Counted::select(known, a, a * b);
            if (product + 1.0).gt(factor).any() { vec![same * factor] } else { vec![] }
        });
        assert_eq!(count, Operations { additions: 1, multiplications: 2, comparisons: 1, ..Operations::default() });
    }

    #[test]
    fn known_kernels_have_the_counts_that_a_hand_finds() {
        let tensor: Tensor<Counted> =
            Tensor::from_rows([[2.0, 0.1, 0.2], [0.3, 3.0, 0.4], [0.5, 0.6, 4.0]].map(|row| row.map(given)));
        let entries = |tensor: Tensor<Counted>| tensor.columns.iter().flat_map(|column| column.0).collect();
        // nine products of three, however their sums are fused: 9 × (3 + 2)
        assert_eq!(operations(|| entries(tensor.dot(&tensor))).flops(), 45);
        // nine minors: 9 × (2 + 1)
        assert_eq!(operations(|| entries(tensor.cofactor())).flops(), 27);
        // a history outlives the kernel that made it, and is given to the next
        let mut kept = tensor;
        operations(|| {
            kept = kept.dot(&tensor);
            vec![]
        });
        assert_eq!(operations(|| vec![kept.trace()]).flops(), 2);
        // the series of exp: 13 terms from the second order on, the argument reduced by three operations
        let argument = given(0.3);
        assert_eq!(operations(|| vec![argument.exp()]).fused, 2 + 11 + 1 + 1);
    }
}
