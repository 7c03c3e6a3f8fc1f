//! Every identifier of the emitted Verilog comes from here: unique in its scope, never a reserved word.

use std::collections::BTreeSet;

use super::module::Module;

/// Hands out identifiers of one scope.
#[derive(Default)]
pub struct Allocator {
    taken: BTreeSet<String>,
}

impl Allocator {
    /// `wanted` itself where it is free and legal; otherwise with a number behind it. Names that differ
    /// only in case count as equal, as some tools and file systems do not tell them apart.
    pub fn allocate(&mut self, wanted: &str) -> String {
        let mut base: String =
            wanted.chars().map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '_' }).collect();
        if base.is_empty() || base.starts_with(|c: char| c.is_ascii_digit()) {
            base.insert(0, 'n');
        }
        let free = |s: &str| !RESERVED.contains(&s) && !self.taken.contains(&s.to_ascii_lowercase());
        let name = if free(&base) {
            base
        } else {
            let mut number = 2..;
            // The range is endless and the set is finite: some number is free.
            number.find_map(|n| Some(format!("{base}_{n}")).filter(|s| free(s))).unwrap_or(base)
        };
        self.taken.insert(name.to_ascii_lowercase());
        name
    }
}

/// Gives every named thing of the module its final identifier; ports first, as they are the interface.
pub(super) fn allocate(module: &mut Module) {
    let mut scope = Allocator::default();
    for fixed in ["aclk", "aresetn"] {
        scope.allocate(fixed);
    }
    for bus in &mut module.buses {
        bus.name = scope.allocate(&bus.name);
    }
    let ports: BTreeSet<u32> = module.inputs.iter().map(|id| id.0).collect();
    for id in module.inputs.clone() {
        rename(module, &mut scope, id.index());
    }
    // An output that shows a node under the node's own name is that node; another name is a second wire.
    for output in 0..module.outputs.len() {
        let node = module.outputs[output].node;
        let own = module.node(node).name.clone();
        let name = scope.allocate(&module.outputs[output].name);
        if own.as_deref() == Some(&module.outputs[output].name) && !ports.contains(&node.0) {
            module.nodes[node.index()].name = Some(name.clone());
        }
        module.outputs[output].name = name;
    }
    let shown: BTreeSet<u32> = module
        .outputs
        .iter()
        .filter(|o| module.node(o.node).name.as_deref() == Some(o.name.as_str()))
        .map(|o| o.node.0)
        .collect();
    for index in 0..module.nodes.len() {
        if !ports.contains(&(index as u32)) && !shown.contains(&(index as u32)) {
            rename(module, &mut scope, index);
        }
    }
    for memory in &mut module.memories {
        memory.name = scope.allocate(&memory.name);
    }
    for instance in &mut module.instances {
        instance.name = scope.allocate(&instance.name);
    }
}

fn rename(module: &mut Module, scope: &mut Allocator, index: usize) {
    if let Some(name) = &module.nodes[index].name {
        module.nodes[index].name = Some(scope.allocate(name));
    }
}

/// The reserved words of Verilog (IEEE 1364-2005) and SystemVerilog (IEEE 1800-2017).
const RESERVED: &[&str] = &[
    "accept_on",
    "alias",
    "always",
    "always_comb",
    "always_ff",
    "always_latch",
    "and",
    "assert",
    "assign",
    "assume",
    "automatic",
    "before",
    "begin",
    "bind",
    "bins",
    "binsof",
    "bit",
    "break",
    "buf",
    "bufif0",
    "bufif1",
    "byte",
    "case",
    "casex",
    "casez",
    "cell",
    "chandle",
    "checker",
    "class",
    "clocking",
    "cmos",
    "config",
    "const",
    "constraint",
    "context",
    "continue",
    "cover",
    "covergroup",
    "coverpoint",
    "cross",
    "deassign",
    "default",
    "defparam",
    "design",
    "disable",
    "dist",
    "do",
    "edge",
    "else",
    "end",
    "endcase",
    "endchecker",
    "endclass",
    "endclocking",
    "endconfig",
    "endfunction",
    "endgenerate",
    "endgroup",
    "endinterface",
    "endmodule",
    "endpackage",
    "endprimitive",
    "endprogram",
    "endproperty",
    "endsequence",
    "endspecify",
    "endtable",
    "endtask",
    "enum",
    "event",
    "eventually",
    "expect",
    "export",
    "extends",
    "extern",
    "final",
    "first_match",
    "for",
    "force",
    "foreach",
    "forever",
    "fork",
    "forkjoin",
    "function",
    "generate",
    "genvar",
    "global",
    "highz0",
    "highz1",
    "if",
    "iff",
    "ifnone",
    "ignore_bins",
    "illegal_bins",
    "implements",
    "implies",
    "import",
    "incdir",
    "include",
    "initial",
    "inout",
    "input",
    "inside",
    "instance",
    "int",
    "integer",
    "interconnect",
    "interface",
    "intersect",
    "join",
    "join_any",
    "join_none",
    "large",
    "let",
    "liblist",
    "library",
    "local",
    "localparam",
    "logic",
    "longint",
    "macromodule",
    "matches",
    "medium",
    "modport",
    "module",
    "nand",
    "negedge",
    "nettype",
    "new",
    "nexttime",
    "nmos",
    "nor",
    "noshowcancelled",
    "not",
    "notif0",
    "notif1",
    "null",
    "or",
    "output",
    "package",
    "packed",
    "parameter",
    "pmos",
    "posedge",
    "primitive",
    "priority",
    "program",
    "property",
    "protected",
    "pull0",
    "pull1",
    "pulldown",
    "pullup",
    "pulsestyle_ondetect",
    "pulsestyle_onevent",
    "pure",
    "rand",
    "randc",
    "randcase",
    "randsequence",
    "rcmos",
    "real",
    "realtime",
    "ref",
    "reg",
    "reject_on",
    "release",
    "repeat",
    "restrict",
    "return",
    "rnmos",
    "rpmos",
    "rtran",
    "rtranif0",
    "rtranif1",
    "s_always",
    "s_eventually",
    "s_nexttime",
    "s_until",
    "s_until_with",
    "scalared",
    "sequence",
    "shortint",
    "shortreal",
    "showcancelled",
    "signed",
    "small",
    "soft",
    "solve",
    "specify",
    "specparam",
    "static",
    "string",
    "strong",
    "strong0",
    "strong1",
    "struct",
    "super",
    "supply0",
    "supply1",
    "sync_accept_on",
    "sync_reject_on",
    "table",
    "tagged",
    "task",
    "this",
    "throughout",
    "time",
    "timeprecision",
    "timeunit",
    "tran",
    "tranif0",
    "tranif1",
    "tri",
    "tri0",
    "tri1",
    "triand",
    "trior",
    "trireg",
    "type",
    "typedef",
    "union",
    "unique",
    "unique0",
    "unsigned",
    "until",
    "until_with",
    "untyped",
    "use",
    "uwire",
    "var",
    "vectored",
    "virtual",
    "void",
    "wait",
    "wait_order",
    "wand",
    "weak",
    "weak0",
    "weak1",
    "while",
    "wildcard",
    "wire",
    "with",
    "within",
    "wor",
    "xnor",
    "xor",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reserved_words_and_repeats_get_another_name() {
        let mut scope = Allocator::default();
        assert_eq!(scope.allocate("step"), "step");
        assert_eq!(scope.allocate("step"), "step_2");
        assert_eq!(scope.allocate("Step"), "Step_3");
        assert_eq!(scope.allocate("edge"), "edge_2");
        assert_eq!(scope.allocate("logic"), "logic_2");
        assert_eq!(scope.allocate("4th"), "n4th");
        assert_eq!(scope.allocate("a.b"), "a_b");
    }

    #[test]
    fn the_reserved_words_are_sorted_and_complete() {
        assert!(RESERVED.is_sorted());
        assert_eq!(RESERVED.len(), 248);
    }
}
