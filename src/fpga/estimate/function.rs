//! A function of at most four bits, as one LUT makes it.

use crate::hdl::Bitwise;

/// Inputs of a LUT.
const PINS: usize = 4;

/// The table of the first bit alone, of the second, of the third, of the fourth.
const COLUMNS: [u16; PINS] = [0xAAAA, 0xCCCC, 0xF0F0, 0xFF00];

/// A function of the bits that it depends on, in order; none depends on a bit twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Function {
    leaves: [u32; PINS],
    count: u8,
    /// The value for each assignment, the first leaf at the lowest place; what stands behind the last leaf is no matter
    /// for it.
    table: u16,
}

impl Function {
    pub const ZERO: Function = Function { leaves: [0; PINS], count: 0, table: 0 };

    pub fn constant(high: bool) -> Function {
        Function { leaves: [0; PINS], count: 0, table: if high { u16::MAX } else { 0 } }
    }

    pub fn leaf(leaf: u32) -> Function {
        Function { leaves: [leaf, 0, 0, 0], count: 1, table: COLUMNS[0] }
    }

    pub fn leaves(&self) -> &[u32] {
        &self.leaves[..usize::from(self.count)]
    }

    /// Whether it takes a LUT: a bit as it is or inverted goes into the LUT that reads it.
    pub fn is_gate(&self) -> bool {
        self.count > 1
    }

    pub fn inverted(self) -> Function {
        Function { table: !self.table, ..self }
    }

    /// The leaves of all; nothing where they are too many.
    pub fn together(functions: &[Function]) -> Option<Vec<u32>> {
        let mut leaves: Vec<u32> = vec![];
        for leaf in functions.iter().flat_map(|function| function.leaves()) {
            if !leaves.contains(leaf) {
                if leaves.len() == PINS {
                    return None;
                }
                leaves.push(*leaf);
            }
        }
        leaves.sort_unstable();
        Some(leaves)
    }

    pub fn bitwise(self, other: Function, operation: Bitwise) -> Option<Function> {
        let leaves = Function::together(&[self, other])?;
        let (left, right) = (self.over(&leaves), other.over(&leaves));
        Some(Function::tabled(
            &leaves,
            match operation {
                Bitwise::And => left & right,
                Bitwise::Or => left | right,
                Bitwise::Xor => left ^ right,
            },
        ))
    }

    /// `condition ? on_true : on_false`.
    pub fn select([condition, on_true, on_false]: [Function; 3]) -> Option<Function> {
        let leaves = Function::together(&[condition, on_true, on_false])?;
        let [condition, on_true, on_false] = [condition, on_true, on_false].map(|f| f.over(&leaves));
        Some(Function::tabled(&leaves, condition & on_true | !condition & on_false))
    }

    /// Whether a cell of carry that has four pins adds the two: where they are equal, the carry is a function of two of
    /// the pins, one and the same for all that is chosen.
    pub fn add_in_one_cell(self, other: Function) -> bool {
        let Some(leaves) = Function::together(&[self, other]) else { return false };
        let (left, right) = (self.over(&leaves), other.over(&leaves));
        let (equal, generated) = (!(left ^ right), left & right);
        let settles = |first: usize, second: usize| {
            [(0, 0), (0, 1), (1, 0), (1, 1)].into_iter().all(|(one, two)| {
                let column = |pin: usize, high: u16| if high == 1 { COLUMNS[pin] } else { !COLUMNS[pin] };
                let cases = equal & column(first, one) & column(second, two);
                generated & cases == 0 || generated & cases == cases
            })
        };
        (0..PINS).any(|first| (first + 1..PINS).any(|second| settles(first, second)))
    }

    /// Its table over leaves among which are its own.
    fn over(self, leaves: &[u32]) -> u16 {
        if leaves == self.leaves() {
            return self.table;
        }
        let place = |leaf: &u32| leaves.iter().position(|other| other == leaf).unwrap_or(0);
        let places: Vec<usize> = self.leaves().iter().map(place).collect();
        let entry = |assignment: usize| -> u16 {
            let own: usize = places.iter().enumerate().map(|(i, p)| (assignment >> p & 1) << i).sum();
            (self.table >> own & 1) << assignment
        };
        (0..1usize << PINS).map(entry).sum()
    }

    /// Without the leaves that make no difference.
    fn tabled(leaves: &[u32], table: u16) -> Function {
        let mut function = Function { leaves: [0; PINS], count: 0, table: 0 };
        let matters = |place: usize| {
            let width = 1 << place;
            (table & COLUMNS[place]) >> width != table & !COLUMNS[place]
        };
        let kept: Vec<usize> = (0..leaves.len()).filter(|place| matters(*place)).collect();
        for (index, place) in kept.iter().enumerate() {
            function.leaves[index] = leaves[*place];
        }
        function.count = kept.len() as u8;
        let entry = |assignment: usize| -> u16 {
            let full: usize = kept.iter().enumerate().map(|(i, place)| (assignment >> i & 1) << place).sum();
            (table >> full & 1) << assignment
        };
        function.table = (0..1usize << PINS).map(entry).sum();
        function
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(condition: u32, on_true: Function, on_false: Function) -> Function {
        Function::select([Function::leaf(condition), on_true, on_false]).unwrap()
    }

    #[test]
    fn leaves_that_make_no_difference_vanish() {
        let [a, b, zero] = [Function::leaf(5), Function::leaf(3), Function::constant(false)];
        assert_eq!(chosen(9, a, a), a);
        assert_eq!(chosen(5, a, zero), a);
        assert_eq!(a.bitwise(zero, Bitwise::And), Some(zero));
        assert_eq!(a.bitwise(b, Bitwise::Xor).unwrap().bitwise(a, Bitwise::Xor), Some(b));
        assert_eq!(a.bitwise(b, Bitwise::Or).unwrap().leaves(), [3, 5]);
        assert_eq!(a.inverted().inverted(), a);
    }

    #[test]
    fn five_leaves_are_too_many() {
        let wide = (1..4)
            .map(Function::leaf)
            .try_fold(Function::leaf(0), |all, leaf| all.bitwise(leaf, Bitwise::And));
        assert_eq!(wide.unwrap().leaves(), [0, 1, 2, 3]);
        assert_eq!(wide.unwrap().bitwise(Function::leaf(7), Bitwise::And), None);
    }

    #[test]
    fn a_load_goes_into_the_adder_and_two_sums_of_three_do_not() {
        let [zero, n, a, b, c] = [0, 1, 2, 3, 4]
            .map(|leaf| if leaf == 0 { Function::constant(false) } else { Function::leaf(leaf) });
        assert!(chosen(9, n, a).add_in_one_cell(b));
        assert!(chosen(9, n, a).add_in_one_cell(chosen(9, zero, b)));
        assert!(!chosen(9, n, a).add_in_one_cell(chosen(8, zero, b)));
        let odd = |x: Function, y: Function, z: Function| {
            x.bitwise(y, Bitwise::Xor).and_then(|both| both.bitwise(z, Bitwise::Xor)).unwrap()
        };
        assert!(!odd(n, a, b).add_in_one_cell(odd(a, b, c)));
    }
}
