//! Expressions: each function returns text of exactly the width asked for.

use super::nets::{Nets, Span};
use crate::hdl::cell::{Bitwise, Cell, NodeId, Relation};
use crate::hdl::module::{Memory, Module};

pub struct Printer<'a> {
    pub module: &'a Module,
    pub nets: &'a Nets,
}

impl Printer<'_> {
    /// What drives a net: the operation of its cell.
    pub fn operation(&self, id: NodeId) -> String {
        let node = self.module.node(id);
        let width = node.word.width();
        match &node.cell {
            Cell::Constant(value) => literal(*value, width),
            Cell::Sum { terms, constant } => self.sum(terms, *constant, width),
            Cell::Select { condition, on_true, on_false } => {
                let [a, b] = [on_true, on_false].map(|&id| self.sized(id, width, 0));
                format!("{} ? {a} : {b}", self.whole(*condition))
            }
            Cell::Compare { relation, left, right } => self.compare(*relation, *left, *right),
            // Modulo 2^width a product of sign-extended words is the signed product.
            Cell::Product { left, right } => {
                format!("{} * {}", self.sized(*left, width, 0), self.sized(*right, width, 0))
            }
            Cell::Logic { operation, operands } => {
                let symbol = match operation {
                    Bitwise::And => " & ",
                    Bitwise::Or => " | ",
                    Bitwise::Xor => " ^ ",
                };
                operands.iter().map(|&o| self.whole(o)).collect::<Vec<_>>().join(symbol)
            }
            Cell::Not { of } => format!("~{}", self.whole(*of)),
            Cell::Concat { parts } => {
                let texts: Vec<String> = parts.iter().map(|&p| self.whole(p)).collect();
                let runs: Vec<String> = texts
                    .chunk_by(|a, b| a == b)
                    .map(|run| {
                        if run.len() > 1 {
                            format!("{{{}{{{}}}}}", run.len(), run[0])
                        } else {
                            run[0].clone()
                        }
                    })
                    .collect();
                format!("{{{}}}", runs.join(", "))
            }
            Cell::Wrap { of } | Cell::Claim { of, .. } | Cell::Wire { driver: Some(of) } => {
                self.sized(*of, width, 0)
            }
            Cell::ShiftRight { of, amount, .. } => self.part(*of, *amount, width),
            Cell::Slice { of, low } => self.part(*of, *low, width),
            // Not operations: they are printed as registers, ports and instances.
            Cell::Input | Cell::Wire { driver: None } | Cell::Register { .. } => String::new(),
            Cell::MemoryRead { .. } | Cell::InstanceOutput { .. } => String::new(),
        }
    }

    /// The node at its own width.
    pub fn whole(&self, id: NodeId) -> String {
        self.sized(id, self.module.node(id).word.width(), 0)
    }

    /// `value(id) * 2^shift` in `width` bits: extended by its sign, or cut.
    pub fn sized(&self, id: NodeId, width: u32, shift: u32) -> String {
        let node = self.module.node(id);
        if shift >= width {
            return literal(0, width);
        }
        if let Some(value) = self.nets.constant(self.module, id) {
            return literal(value << shift, width);
        }
        let room = width - shift;
        let Some(span) = self.nets.span(self.module, id) else {
            // A widening or an inlined operation, read whole.
            return match &node.cell {
                Cell::Wrap { of } | Cell::Claim { of, .. } => self.sized(*of, width, shift),
                Cell::Concat { .. } => self.operation(id),
                Cell::Not { .. } => self.operation(id),
                // A shifted operand is a concatenation already.
                Cell::Sum { terms, constant: 0 } if terms.len() == 1 && !terms[0].negate => {
                    self.operation(id)
                }
                _ => format!("({})", self.operation(id)),
            };
        };
        let cut = Span { width: span.width.min(room), ..span };
        let mut parts = vec![];
        let spare = room - cut.width;
        if spare > 0 {
            let top = self.span_text(Span { low: span.low + span.width - 1, width: 1, ..span });
            parts.push(match (span.signed, spare) {
                (false, _) => format!("{spare}'d0"),
                (true, 1) => top,
                (true, _) => format!("{{{spare}{{{top}}}}}"),
            });
        }
        parts.push(self.span_text(cut));
        if shift > 0 {
            parts.push(format!("{shift}'d0"));
        }
        match parts.as_slice() {
            [only] => only.clone(),
            _ => format!("{{{}}}", parts.join(", ")),
        }
    }

    /// The node as an index of the memory, in as many bits as the last word needs. Verilog would take it as a negative
    /// number if it were signed.
    pub fn index(&self, id: NodeId, memory: &Memory) -> String {
        let width = memory.index_width();
        let text = self.sized(id, width, 0);
        if self.is_signed(id, width) { format!("$unsigned({})", unwrapped(&text)) } else { text }
    }

    /// Whether Verilog takes what [`Printer::sized`] returns as a signed expression: it does where all operands are
    /// whole nets that were declared so.
    fn is_signed(&self, id: NodeId, width: u32) -> bool {
        if self.nets.constant(self.module, id).is_some() {
            return false;
        }
        if let Some(span) = self.nets.span(self.module, id) {
            let word = self.module.node(span.base).word;
            return word.is_signed()
                && word.width() == width
                && width > 1
                && span.low == 0
                && span.width == width;
        }
        let all = |ids: &[NodeId]| ids.iter().all(|&id| self.is_signed(id, width));
        match &self.module.node(id).cell {
            Cell::Sum { terms, constant } => {
                *constant == 0 && terms.iter().all(|t| t.shift == 0 && self.is_signed(t.of, width))
            }
            Cell::Select { on_true, on_false, .. } => all(&[*on_true, *on_false]),
            Cell::Product { left, right } => all(&[*left, *right]),
            Cell::Logic { operands, .. } => all(operands),
            Cell::Not { of } | Cell::Wrap { of } | Cell::Claim { of, .. } => self.is_signed(*of, width),
            _ => false,
        }
    }

    fn part(&self, id: NodeId, low: u32, width: u32) -> String {
        match self.nets.span(self.module, id) {
            // Behind the highest bit stand copies of the sign, or nothing.
            Some(span) if low >= span.width && !span.signed => literal(0, width),
            Some(span) => {
                let low = low.min(span.width - 1);
                self.span_text(Span { low: span.low + low, width: width.min(span.width - low), ..span })
            }
            None => match self.nets.constant(self.module, id) {
                Some(value) => literal(value >> low, width),
                None => self.sized(id, width, 0),
            },
        }
    }

    fn span_text(&self, span: Span) -> String {
        let name = self.nets.name(span.base).unwrap_or_default();
        let full = self.module.node(span.base).word.width();
        match (span.low, span.width) {
            (0, width) if width == full => name.to_string(),
            (low, 1) => format!("{name}[{low}]"),
            (low, width) => format!("{name}[{}:{low}]", low + width - 1),
        }
    }

    fn sum(&self, terms: &[crate::hdl::Term], constant: i128, width: u32) -> String {
        let mut text = String::new();
        // A term that is shifted out of the sum's word has cancelled against others.
        for term in terms.iter().filter(|term| term.shift < width) {
            let operand = self.sized(term.of, width, term.shift);
            text += match (term.negate, text.is_empty()) {
                (false, true) => "",
                (false, false) => " + ",
                (true, true) => "-",
                (true, false) => " - ",
            };
            text += &operand;
        }
        match constant {
            0 if text.is_empty() => literal(0, width),
            0 => text,
            c if text.is_empty() => literal(c, width),
            c if c < 0 && c != i128::MIN => format!("{text} - {}", literal(-c, width)),
            c => format!("{text} + {}", literal(c, width)),
        }
    }

    fn compare(&self, relation: Relation, left: NodeId, right: NodeId) -> String {
        let [a, b] = [left, right].map(|id| self.module.node(id).word);
        let signed = a.is_signed() || b.is_signed();
        let needed = |w: crate::hdl::Word| w.width() + u32::from(signed && !w.is_signed());
        let width = needed(a).max(needed(b));
        let [l, r] = [left, right].map(|id| self.sized(id, width, 0));
        let symbol = match relation {
            Relation::Equal => "==",
            Relation::NotEqual => "!=",
            Relation::Less => "<",
            Relation::LessOrEqual => "<=",
        };
        match relation {
            Relation::Less | Relation::LessOrEqual if signed => {
                format!("$signed({l}) {symbol} $signed({r})")
            }
            // Two signed operands would be compared as signed ones.
            Relation::Less | Relation::LessOrEqual if self.is_signed(left, width) => {
                format!("$unsigned({}) {symbol} {r}", unwrapped(&l))
            }
            _ => format!("{l} {symbol} {r}"),
        }
    }
}

/// A literal of this width: small numbers in decimal, others in hexadecimal.
pub fn literal(value: i128, width: u32) -> String {
    let bits = if width >= 128 { value as u128 } else { value as u128 & ((1 << width) - 1) };
    if bits < 4096 { format!("{width}'d{bits}") } else { format!("{width}'h{bits:x}") }
}

/// The text without the parentheses that enclose all of it, if any do.
pub fn unwrapped(text: &str) -> &str {
    let inner = text.strip_prefix('(').and_then(|t| t.strip_suffix(')'));
    let balanced = |text: &&str| {
        let mut depth = 0i32;
        text.chars().all(|c| {
            depth += i32::from(c == '(') - i32::from(c == ')');
            depth >= 0
        })
    };
    inner.filter(balanced).unwrap_or(text)
}
