//! Signals and the operators that make a core read like its formula.
//!
//! `&p0 - 2 * &p1 + &p2` is one [`Sum`]: nothing is built until it is named or used, and then it is one
//! cell whose width is that of the whole mask.

use std::ops;
use std::panic::Location;

use super::cell::NodeId;
use super::{Builder, Word};

/// A node of the module under construction.
#[derive(Clone)]
pub struct Signal {
    pub(super) builder: Builder,
    pub(super) id: NodeId,
}

impl Signal {
    pub fn word(&self) -> Word {
        self.builder.node(self.id, |n| n.word)
    }
    pub fn width(&self) -> u32 {
        self.word().width()
    }
    /// Clocks after the inputs of time 0; nothing for constants.
    pub fn time(&self) -> Option<u32> {
        self.builder.node(self.id, |n| n.time)
    }
    /// Whether both are one node of one module.
    pub fn is_same(&self, other: &Signal) -> bool {
        self.id == other.id
    }
    /// The name it has been given.
    pub fn name(&self) -> Option<String> {
        self.builder.node(self.id, |n| n.name.clone())
    }
}

/// `constant + sum of coefficient * signal`, not yet built.
#[derive(Clone)]
pub struct Sum {
    pub(super) terms: Vec<(i128, Signal)>,
    pub(super) constant: i128,
    pub(super) place: &'static Location<'static>,
}

/// Something that can be used as a signal.
#[derive(Clone)]
pub enum Expr {
    Signal(Signal),
    Sum(Sum),
}

impl Sum {
    /// The sum of `coefficient * signal` over a list; coefficients of 0 vanish.
    #[track_caller]
    pub fn weighted<'a>(terms: impl IntoIterator<Item = (i128, &'a Signal)>) -> Sum {
        let terms = terms.into_iter().filter(|(c, _)| *c != 0).map(|(c, s)| (c, s.clone())).collect();
        Sum { terms, constant: 0, place: Location::caller() }
    }

    fn plus(mut self, other: Sum, factor: i128) -> Sum {
        self.terms.extend(other.terms.into_iter().map(|(c, s)| (c * factor, s)));
        self.constant += factor * other.constant;
        self
    }

    fn times(mut self, factor: i128) -> Sum {
        self.terms.iter_mut().for_each(|(c, _)| *c *= factor);
        self.constant *= factor;
        self
    }
}

impl From<&Signal> for Sum {
    #[track_caller]
    fn from(signal: &Signal) -> Sum {
        Sum { terms: vec![(1, signal.clone())], constant: 0, place: Location::caller() }
    }
}
impl From<Signal> for Sum {
    #[track_caller]
    fn from(signal: Signal) -> Sum {
        Sum { terms: vec![(1, signal)], constant: 0, place: Location::caller() }
    }
}
impl From<i128> for Sum {
    #[track_caller]
    fn from(constant: i128) -> Sum {
        Sum { terms: vec![], constant, place: Location::caller() }
    }
}
impl From<Signal> for Expr {
    fn from(signal: Signal) -> Expr {
        Expr::Signal(signal)
    }
}
impl From<&Signal> for Expr {
    fn from(signal: &Signal) -> Expr {
        Expr::Signal(signal.clone())
    }
}
impl From<Sum> for Expr {
    fn from(sum: Sum) -> Expr {
        Expr::Sum(sum)
    }
}

macro_rules! additive {
    ($left:ty, $right:ty) => {
        impl ops::Add<$right> for $left {
            type Output = Sum;
            #[track_caller]
            fn add(self, other: $right) -> Sum {
                Sum::from(self).plus(Sum::from(other), 1)
            }
        }
        impl ops::Sub<$right> for $left {
            type Output = Sum;
            #[track_caller]
            fn sub(self, other: $right) -> Sum {
                Sum::from(self).plus(Sum::from(other), -1)
            }
        }
    };
}
additive!(&Signal, &Signal);
additive!(&Signal, Sum);
additive!(&Signal, i128);
additive!(Sum, &Signal);
additive!(Sum, Sum);
additive!(Sum, i128);

macro_rules! scalable {
    ($signal:ty) => {
        impl ops::Mul<$signal> for i128 {
            type Output = Sum;
            #[track_caller]
            fn mul(self, signal: $signal) -> Sum {
                Sum::from(signal).times(self)
            }
        }
        impl ops::Neg for $signal {
            type Output = Sum;
            #[track_caller]
            fn neg(self) -> Sum {
                Sum::from(self).times(-1)
            }
        }
        impl ops::Shl<u32> for $signal {
            type Output = Sum;
            #[track_caller]
            fn shl(self, amount: u32) -> Sum {
                Sum::from(self).times(1 << amount)
            }
        }
    };
}
scalable!(&Signal);
scalable!(Sum);

macro_rules! bitwise {
    ($trait:ident, $method:ident, $operation:ident) => {
        impl ops::$trait<&Signal> for &Signal {
            type Output = Signal;
            #[track_caller]
            fn $method(self, other: &Signal) -> Signal {
                self.builder.logic(super::cell::Bitwise::$operation, &[self, other])
            }
        }
        impl ops::$trait<Signal> for &Signal {
            type Output = Signal;
            #[track_caller]
            fn $method(self, other: Signal) -> Signal {
                self.builder.logic(super::cell::Bitwise::$operation, &[self, &other])
            }
        }
        impl ops::$trait<&Signal> for Signal {
            type Output = Signal;
            #[track_caller]
            fn $method(self, other: &Signal) -> Signal {
                self.builder.logic(super::cell::Bitwise::$operation, &[&self, other])
            }
        }
        impl ops::$trait<Signal> for Signal {
            type Output = Signal;
            #[track_caller]
            fn $method(self, other: Signal) -> Signal {
                self.builder.logic(super::cell::Bitwise::$operation, &[&self, &other])
            }
        }
    };
}
bitwise!(BitAnd, bitand, And);
bitwise!(BitOr, bitor, Or);
bitwise!(BitXor, bitxor, Xor);

impl ops::Not for &Signal {
    type Output = Signal;
    #[track_caller]
    fn not(self) -> Signal {
        self.builder.not(self)
    }
}
impl ops::Not for Signal {
    type Output = Signal;
    #[track_caller]
    fn not(self) -> Signal {
        self.builder.not(&self)
    }
}
