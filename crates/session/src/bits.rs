//! Numbers in the head of a checkpoint.

use serde::{Deserialize, Serialize};

/// A number by its bits, which a text must not round.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bits(u64);

impl From<f64> for Bits {
    fn from(number: f64) -> Self {
        Self(number.to_bits())
    }
}

impl From<Bits> for f64 {
    fn from(bits: Bits) -> Self {
        Self::from_bits(bits.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_bits() {
        for number in [0.1 + 0.2, f64::NAN, -0.0, 5e-324] {
            let text = serde_json::to_string(&Bits::from(number)).unwrap();
            let read: Bits = serde_json::from_str(&text).unwrap();
            assert_eq!(f64::from(read).to_bits(), number.to_bits());
        }
    }
}
