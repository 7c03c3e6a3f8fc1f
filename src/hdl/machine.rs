//! Small state machines, one register a state: exactly one of them is 1.

use super::Word;
use super::builder::Builder;
use super::expression::Signal;
use crate::error::Error;

/// A machine under construction; it starts in its first state.
pub struct StateMachine {
    name: String,
    states: Vec<(String, Signal)>,
    builder: Builder,
    /// The clauses of each state's register, closed by [`StateMachine::finish`].
    moves: Vec<(usize, Signal, usize)>,
}

impl Builder {
    /// A machine with these states; the first one is taken at reset.
    #[track_caller]
    pub fn state_machine(&self, name: &str, states: &[&str]) -> StateMachine {
        let mut registers = vec![];
        for (index, state) in states.iter().enumerate() {
            let bit = self.register_reset(format!("{name}_{state}"), Word::bit(), i128::from(index == 0));
            registers.push((state.to_string(), bit));
        }
        StateMachine { name: name.into(), states: registers, builder: self.clone(), moves: vec![] }
    }
}

impl StateMachine {
    /// 1 while the machine is in the state.
    #[track_caller]
    pub fn is(&self, state: &str) -> Signal {
        self.states[self.index(state)].1.clone()
    }

    /// From one state to another at an edge where `condition` is 1. Of several moves that apply, the one
    /// given first is made.
    #[track_caller]
    pub fn go(&mut self, from: &str, condition: &Signal, to: &str) {
        let (from, to) = (self.index(from), self.index(to));
        self.moves.push((from, condition.clone(), to));
    }

    #[track_caller]
    fn index(&self, state: &str) -> usize {
        self.states.iter().position(|(name, _)| name == state).unwrap_or_else(|| {
            self.builder.fail(|_| {
                Error::usage(format!("machine {} has no state {state}", self.name))
                    .help("name it where the machine is made")
            });
            0
        })
    }

    /// Builds the moves.
    #[track_caller]
    pub fn finish(self) {
        let m = &self.builder;
        let mut taken: Vec<(usize, Signal)> = vec![];
        for (from, condition, to) in self.moves {
            let mut step = &self.states[from].1 & &condition;
            for (other, earlier) in &taken {
                if *other == from {
                    step = &step & !earlier;
                }
            }
            if from != to {
                m.on(&step, &self.states[from].1, m.bit(false));
                m.on(&step, &self.states[to].1, m.bit(true));
            }
            taken.push((from, condition));
        }
    }
}
