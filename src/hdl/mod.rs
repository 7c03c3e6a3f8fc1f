//! The hardware description language: a design is data.
//!
//! ```
//! use subdiv_rtl::hdl::{Builder, Word};
//!
//! // A second difference costs the two bits of its mask, not one more for every adder.
//! let m = Builder::new("second_difference");
//! let [a, b, c] = ["a", "b", "c"].map(|name| m.input(name, Word::signed(8)));
//! let difference = m.wire("difference", &a - 2 * &b + &c);
//! assert_eq!(difference.word().width(), 10);
//! m.output("y", &difference);
//! let module = m.finish().unwrap();
//! ```
//!
//! Building ([`Builder`]) makes a graph of [cells](cell); [`flat`] lays the hierarchy out as one list,
//! which the [simulator](simulate) walks with integers and the [prover](linear) with exact linear forms;
//! [`verilog`] prints it.

mod arithmetic;
mod builder;
pub mod cell;
mod count;
mod expression;
pub mod fault;
pub mod flat;
mod form;
pub mod inventory;
pub mod linear;
mod live;
mod logic;
mod machine;
mod module;
mod names;
pub mod ports;
pub mod serial;
pub mod simulate;
pub mod skew;
mod state;
mod stream;
pub mod vcd;
pub mod verilog;
mod word;

pub use builder::{Builder, Placed};
pub use cell::{Bitwise, Cell, Node, NodeId, Relation, Term};
pub use count::Counts;
pub use expression::{Expr, Signal, Sum};
pub use flat::Flat;
pub use linear::LinearForms;
pub use machine::StateMachine;
pub use module::{Bus, Direction, Instance, Lane, MadeOf, Memory, MemoryWrite, Module, Output};
pub use names::Allocator;
pub use simulate::{Domain, Integers, Simulator};
pub use state::MemoryHandle;
pub use stream::{StreamBeat, StreamInput};
pub use word::Word;
